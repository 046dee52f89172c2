// A folder for files of pictures.
#pragma once

#include <gtest/gtest.h>

#include "core/testing/folder.h"

namespace keypose {

class ImageIo : public ::testing::Test, public TestingFolder {};

}  // namespace keypose
