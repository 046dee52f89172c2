#include "core/io/pictures/color_profile.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/pictures/reduced_image.h"
#include "core/testing/folder.h"
#include "core/testing/paths.h"

namespace keypose::color_profile_test {

double Linear(double level) {
  const double v = level / 255;
  return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}
double Level(double linear) {
  const double l = std::clamp(linear, 0.0, 1.0);
  return 255 * (l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
}

/// Display P3 to sRGB by the matrix of the two sets of primaries (both D65).
void ExpectSrgbOfP3(const std::uint8_t* p3, const std::uint8_t* srgb) {
  constexpr double kMatrix[3][3] = {
      {1.2249401, -0.2249404, 0}, {-0.0420569, 1.0420571, 0}, {-0.0196376, -0.0786361, 1.0982735}};
  for (int c = 0; c < 3; ++c) {
    double linear = 0;
    for (int k = 0; k < 3; ++k) linear += kMatrix[c][k] * Linear(p3[k]);
    EXPECT_NEAR(srgb[c], Level(linear), 1.5)
        << int{p3[0]} << " " << int{p3[1]} << " " << int{p3[2]};
  }
}

Image8 Colours() {
  Image8 image(16, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(17 * x);
      image.at(x, y)[1] = static_cast<std::uint8_t>(17 * y);
      image.at(x, y)[2] = static_cast<std::uint8_t>(255 - 8 * (x + y));
    }
  return image;
}

TEST(InSrgb, DisplayP3IsConvertedByThePrimaries) {
  const Image8 p3 = Colours(), srgb = InSrgb(p3, DisplayP3Profile());
  for (int p = 0; p < 256; ++p) ExpectSrgbOfP3(&p3.data[3 * p], &srgb.data[3 * p]);
}

TEST(InSrgb, SixteenBitsAreConvertedToAHundredthOfALevel) {
  Image16 p3(16, 16, 3);
  for (std::size_t i = 0; i < p3.data.size(); ++i)
    p3.data[i] = static_cast<std::uint16_t>(i * 40503 % 65536);
  const Image16 srgb = InSrgb(p3, DisplayP3Profile());
  constexpr double kMatrix[3][3] = {
      {1.2249401, -0.2249404, 0}, {-0.0420569, 1.0420571, 0}, {-0.0196376, -0.0786361, 1.0982735}};
  double sum = 0;
  for (std::size_t i = 0; i < p3.data.size(); ++i) {
    double linear = 0;
    for (int k = 0; k < 3; ++k)
      linear += kMatrix[i % 3][k] * Linear(p3.data[i / 3 * 3 + k] / 257.0);
    const double off = std::abs(srgb.data[i] - 257 * Level(linear));
    // The profile's numbers have 16 bits after the point, which the steep curve near black shows.
    EXPECT_LT(off, 26) << i;
    sum += off;
  }
  EXPECT_LT(sum / static_cast<double>(p3.data.size()), 1.5);
  EXPECT_EQ(InSrgb(p3, ProfileOf({0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06})).data, p3.data);
}

TEST(InSrgb, SrgbAndWhatIsNoProfileOfRgbStayToTheBit) {
  const std::string srgb = ProfileOf({0.64, 0.33}, {0.30, 0.60}, {0.15, 0.06});
  EXPECT_EQ(InSrgb(Colours(), srgb).data, Colours().data);
  EXPECT_EQ(InSrgb(Colours(), "").data, Colours().data);
  EXPECT_EQ(InSrgb(Colours(), "no profile").data, Colours().data);
  EXPECT_EQ(InSrgb(Image8(4, 4, 1, 90), DisplayP3Profile()).data, Image8(4, 4, 1, 90).data)
      << "a mask";
}

class ProfiledPicture : public ::testing::Test, public TestingFolder {
 protected:
  ImageF levels() const {
    const Image8 colours = Colours();
    ImageF levels(colours.width, colours.height, 3);
    std::copy(colours.data.begin(), colours.data.end(), levels.data.begin());
    return levels;
  }
};

TEST_F(ProfiledPicture, IsReadAsSrgbFromPngAndTiff) {
  for (const char* name : {"p3.png", "p3.tif"}) {
    WriteLevels(path() / name, levels(), 16, DisplayP3Profile());
    const Image16 deep = ReadAsStored(path() / name).sixteen;
    WriteLevels(path() / name, levels(), 8, DisplayP3Profile());
    const Image8 read = ReadImage(path() / name, 3), p3 = Colours();
    for (std::size_t i = 0; i < read.data.size(); ++i)
      ASSERT_NEAR(deep.data[i] / 257.0, read.data[i], 1.5) << name;
    for (int p = 0; p < 256; ++p) ExpectSrgbOfP3(&p3.data[3 * p], &read.data[3 * p]);
    EXPECT_EQ(ReadLevels(path() / name, 3).data, levels().data)
        << "filmed pictures keep their levels";
  }
}

// The same photographs, stored as a phone does and as sRGB.
TEST(ReportedPictures, OfDisplayP3HaveTheColoursOfSrgb) {
  const std::filesystem::path folder = DataFolder() / "reports/24_color_profiles";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "the data of public reports is not here";
  for (int i = 0; i < 8; ++i) {
    const std::string name = "IMG_" + std::to_string(i) + ".jpg";
    for (const int eighths : {8, 4}) {
      const Image8 p3 = ReadReduced(folder / "display_p3" / name, 3, eighths),
                   srgb = ReadReduced(folder / "srgb" / name, 3, eighths);
      ASSERT_EQ(p3.data.size(), srgb.data.size());
      double sum = 0;
      for (std::size_t k = 0; k < p3.data.size(); ++k) sum += std::abs(p3.data[k] - srgb.data[k]);
      EXPECT_LT(sum / static_cast<double>(p3.data.size()), 1.5) << name << ", as two JPEGs differ";
    }
  }
}

}  // namespace keypose::color_profile_test
