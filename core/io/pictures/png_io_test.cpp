#include "core/io/pictures/png_io.h"

#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::png_io_test {

class Files : public ::testing::Test, public TestingFolder {};

TEST_F(Files, MaskOfOneBitAPixelComesBack) {
  for (const int width : {1, 8, 13}) {
    Image8 mask(width, 5, 1), expected(width, 5, 1);
    for (std::size_t i = 0; i < mask.data.size(); ++i) {
      mask.data[i] = i % 3 == 0 ? 128 : i % 5 == 0 ? 255 : 127;
      expected.data[i] = mask.data[i] > 127 ? 255 : 0;
    }
    WriteMaskPng(folder_ / "mask.png", mask);
    EXPECT_EQ(ReadImage(folder_ / "mask.png", 1).data, expected.data) << width;
  }
  EXPECT_EQ(ReadFile(folder_ / "mask.png").at(24), 1) << "bits of a pixel";
}

}  // namespace keypose::png_io_test
