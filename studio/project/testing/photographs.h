// A project with photographs of poses.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "core/io/text/files.h"
#include "core/testing/dng.h"
#include "core/testing/folder.h"
#include "core/values/image.h"

namespace keypose::studio {

class Photographs : public ::testing::Test, public TestingFolder {
 protected:
  Photographs() {
    std::filesystem::create_directories(photos());
    WriteFile(folder_ / "pipeline.yaml", "name: raw\nposes: {rest: photos/rest}\ntemplate: rest\n");
  }

  std::filesystem::path photos() const { return folder_ / "photos/rest"; }
  void Put(const std::string& name) const { WriteFile(photos() / name, name); }
  /// Grey of one linear value.
  void PutRaw(const std::string& name, float linear) const {
    WriteDng(photos() / name, ImageF(64, 48, 3, linear), {});
  }
};

}  // namespace keypose::studio
