#include "core/io/pictures/raw_io.h"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>

#include "core/io/text/files.h"
#include "core/pictures/srgb.h"
#include "core/testing/dng.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::raw_io_test {

namespace fs = std::filesystem;
using Colour = std::array<double, 3>;

/// Linear colours, left to right.
const std::array<Colour, 4> kPatches = {
    {{0.18, 0.18, 0.18}, {0.5, 0.2, 0.1}, {0.1, 0.3, 0.4}, {0.05, 0.06, 0.04}}};
constexpr int kPatch_px = 64, kHeight_px = 96;

class Raw : public ::testing::Test, public TestingFolder {
 protected:
  fs::path Patches(const DngOptions& options) const {
    ImageF linear(kPatch_px * static_cast<int>(kPatches.size()), kHeight_px, 3);
    for (int y = 0; y < linear.height; ++y)
      for (int x = 0; x < linear.width; ++x)
        for (int c = 0; c < 3; ++c)
          linear.at(x, y)[c] = static_cast<float>(kPatches[x / kPatch_px][c]);
    const fs::path file = folder_ / "patches.dng";
    WriteDng(file, linear, options);
    return file;
  }
};

void ExpectPatches(const Image8& image, bool turned) {
  for (std::size_t i = 0; i < kPatches.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      const int along = kPatch_px * static_cast<int>(i) + kPatch_px / 2;
      const std::uint8_t* pixel =
          turned ? image.at(kHeight_px / 2, along) : image.at(along, kHeight_px / 2);
      // Fractions of 4 digits in the colour matrix, and LibRaw's own tables.
      EXPECT_NEAR(pixel[c], 255 * SrgbFromLinear(kPatches[i][c]), 2.5)
          << "patch " << i << ", " << c;
    }
}

TEST_F(Raw, IsDevelopedToTheColoursOfTheScene) {
  const Image8 image = ReadRaw(Patches({}));
  EXPECT_EQ(image.width, kPatch_px * 4);
  EXPECT_EQ(image.height, kHeight_px);
  ExpectPatches(image, false);
}

TEST_F(Raw, IsDevelopedWithTheCamerasWhiteBalance) {
  ExpectPatches(ReadRaw(Patches({.neutral = {0.55, 1, 0.7}})), false);
}

TEST_F(Raw, KeepsItsExposureWhateverIsInThePicture) {
  const Image8 dark = ReadRaw(Patches({}));
  ImageF linear(kPatch_px * 4, kHeight_px, 3, 0.9f);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kPatch_px; ++x)
      for (int c = 0; c < 3; ++c) linear.at(x, y)[c] = 0.18f;
  WriteDng(folder_ / "bright.dng", linear, {});
  const Image8 bright = ReadRaw(folder_ / "bright.dng");
  EXPECT_NEAR(bright.at(kPatch_px / 2, 48)[1], dark.at(kPatch_px / 2, 48)[1], 1);
}

TEST_F(Raw, ComesUpright) {
  const fs::path file = Patches({.orientation = 6});
  const ImageInfo info = ReadRawInfo(file);
  EXPECT_EQ(info.width, kHeight_px);
  EXPECT_EQ(info.height, kPatch_px * 4);
  EXPECT_EQ(info.camera_model, "Keypose Test");
  const Image8 image = ReadRaw(file);
  ASSERT_EQ(image.width, kHeight_px);
  ExpectPatches(image, true);
}

TEST_F(Raw, ThatIsDamagedIsNamed) {
  const fs::path file = Patches({});
  const std::string bytes = ReadFile(file);
  WriteFile(file, "GIF89a" + bytes.substr(6));
  EXPECT_THROW(ReadRaw(file), InputError);
  WriteFile(file, bytes.substr(0, 100));
  EXPECT_THROW(ReadRaw(file), InputError);
  WriteFile(file, "");
  EXPECT_THROW(ReadRawInfo(file), InputError);
  EXPECT_THROW(ReadRaw(folder_ / "none.nef"), DiskError);
}

}  // namespace keypose::raw_io_test
