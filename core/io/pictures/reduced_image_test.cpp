#include "core/io/pictures/reduced_image.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/testing/waves.h"
#include "core/values/errors.h"

namespace keypose::reduced_image_test {

int LargestDifference(const Image8& a, const Image8& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.channels, b.channels);
  int largest = a.data.size() == b.data.size() ? 0 : 255;
  for (std::size_t i = 0; i < std::min(a.data.size(), b.data.size()); ++i)
    largest = std::max(largest, std::abs(a.data[i] - b.data[i]));
  return largest;
}

TEST(EighthsFor, TakesTheFewestThatKeepThePixels) {
  EXPECT_EQ(EighthsFor(4160, 3120, 2000), 4);
  EXPECT_EQ(EighthsFor(3000, 4000, 2000), 4);
  EXPECT_EQ(EighthsFor(3999, 3000, 2000), 5);
  EXPECT_EQ(EighthsFor(6000, 4000, 2000), 3);
  EXPECT_EQ(EighthsFor(1536, 1024, 2000), 8);
  EXPECT_EQ(EighthsFor(2000, 1500, 2000), 8);
  EXPECT_EQ(EighthsFor(16384, 16384, 500), 1);
}

TEST(Reduced, PixelsAreMeansOfThoseTheyCover) {
  Image8 image(5, 4, 1);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<std::uint8_t>(10 * i);
  const Image8 half = Reduced(image, 4);  // 2 x 2 pixels each; the last column is repeated
  ASSERT_EQ(half.width, 3);
  ASSERT_EQ(half.height, 2);
  EXPECT_EQ(half.data, (std::vector<std::uint8_t>{30, 50, 65, 130, 150, 165}));
  EXPECT_EQ(Reduced(image, 8).data, image.data);
  // 8/3 pixels each: 1, 1 and two thirds.
  Image8 row(8, 8, 1);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 8; ++x) *row.at(x, y) = static_cast<std::uint8_t>(x * x * 4);
  const Image8 three = Reduced(row, 3);
  ASSERT_EQ(three.width, 3);
  EXPECT_EQ(*three.at(0, 0), std::lround((0 + 4 + 16 * 2 / 3.0) * 3 / 8));
  EXPECT_EQ(*three.at(1, 1), std::lround((16 / 3.0 + 36 + 64 + 100 / 3.0) * 3 / 8));
}

class ReducedFiles : public ::testing::Test, public TestingFolder {};

TEST_F(ReducedFiles, JpegsAreDecodedWhereAndAsTheWholePictureIs) {
  // 171 and 150: no multiples of what the decoder works in.
  const Image8 waves = Waves(171, 150);
  for (const int orientation : {1, 2, 3, 4, 5, 6, 7, 8}) {
    ExifToWrite exif;
    exif.orientation = orientation;
    const fs::path path = folder_ / ("waves" + std::to_string(orientation) + ".jpg");
    WriteImage(path, waves, 98, &exif);
    for (const int channels : {1, 3}) {
      const Image8 whole = ReadImage(path, channels);
      for (int eighths = 1; eighths <= 8; ++eighths)
        EXPECT_LE(LargestDifference(ReadReduced(path, channels, eighths), Reduced(whole, eighths)),
                  6)  // at the far border, where the decoder continues what it does not see
            << "orientation " << orientation << ", " << channels << " channels, " << eighths;
    }
  }
}

TEST_F(ReducedFiles, OtherPicturesAreAveraged) {
  const Image8 waves = Waves(100, 61);
  WriteImage(folder_ / "waves.png", waves);
  EXPECT_EQ(ReadReduced(folder_ / "waves.png", 3, 3).data, Reduced(waves, 3).data);
  for (const int eighths : {1, 3, 4, 7}) {
    Image8 mask(803, 605, 1);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        *mask.at(x, y) = std::hypot(x - 401, y - 333) < 250 ? 255 : 0;
    WriteGreyMaskPng(folder_ / "mask.png", mask);
    EXPECT_EQ(ReadImage(folder_ / "mask.png", 1).data, mask.data);
    EXPECT_EQ(ReadReduced(folder_ / "mask.png", 1, eighths).data, Reduced(mask, eighths).data);
  }
  Image8 luma(100, 61, 1);
  for (std::size_t i = 0; i < luma.data.size(); ++i) luma.data[i] = waves.data[3 * i];
  WriteImage(folder_ / "luma.jpg", luma, 98);
  EXPECT_LE(LargestDifference(ReadReduced(folder_ / "luma.jpg", 1, 4), Reduced(luma, 4)), 4);
  EXPECT_EQ(ReadReduced(folder_ / "luma.jpg", 3, 4).data,
            Reduced(ReadImage(folder_ / "luma.jpg", 3), 4).data);
}

/// Grey that rises to the right, and as slowly downwards.
Image8 Ramp(int width, int height) {
  Image8 image(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      *image.at(x, y) = static_cast<std::uint8_t>(20 + (x + y) * 200 / (width + height));
  return image;
}

/// The mean along one axis of what weighs less with the distance from pixel k's centre.
template <class Value>
double Mean(int size, int count, int k, const Value& value) {
  const double step = static_cast<double>(size) / count;
  double sum = 0, total = 0;
  for (int i = 0; i < size; ++i) {
    const double weight = std::max(0.0, 1 - std::abs((i + 0.5) / step - k - 0.5));
    sum += weight * value(i), total += weight;
  }
  return sum / total;
}

Image8 ReducedTo(const Image8& whole, int width, int height) {
  Image8 part(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      *part.at(x, y) =
          static_cast<std::uint8_t>(std::lround(Mean(whole.height, height, y, [&](int j) {
            return Mean(whole.width, width, x, [&](int i) { return *whole.at(i, j); });
          })));
  return part;
}

TEST_F(ReducedFiles, ToASizePixelsAreMeansOfThoseAroundTheirCentres) {
  const int width = 81, height = 60;
  WriteImage(folder_ / "ramp.png", Ramp(width, height));
  WriteImage(folder_ / "ramp.jpg", Ramp(width, height), 98);
  ExifToWrite turned;
  turned.orientation = 6;
  WriteImage(folder_ / "turned.jpg", Ramp(height, width), 98, &turned);
  for (const int longer_px : {80, 61, 40, 17, 4})
    for (const char* name : {"ramp.png", "ramp.jpg", "turned.jpg"}) {
      const Image8 whole = ReadImage(folder_ / name, 1),
                   part = ReadReducedTo(folder_ / name, 1, longer_px);
      EXPECT_EQ(std::max(part.width, part.height), longer_px);
      EXPECT_EQ(std::min(part.width, part.height),
                std::max(1L, std::lround(1.0 * height * longer_px / width)));
      // A JPEG's means are rounded twice, and uncertain at the border.
      EXPECT_LE(LargestDifference(part, ReducedTo(whole, part.width, part.height)),
                std::string(name) == "ramp.png" ? 1 : 4)
          << name << " to " << longer_px;
    }
  EXPECT_EQ(ReadReducedTo(folder_ / "ramp.png", 1, width).data, Ramp(width, height).data);
  EXPECT_EQ(ReadReducedTo(folder_ / "ramp.png", 1, 2000).data, Ramp(width, height).data);
}

TEST_F(ReducedFiles, ToASizeAMaskLiesWhereItsPhotographDoes) {
  // 5/8 and 4/8 of neither side are whole pixels.
  Image8 disc(811, 607, 1);
  for (int y = 0; y < disc.height; ++y)
    for (int x = 0; x < disc.width; ++x)
      *disc.at(x, y) = std::hypot(x + 0.5 - 600, y + 0.5 - 400) < 150 ? 255 : 0;
  WriteGreyMaskPng(folder_ / "disc.png", disc);
  WriteImage(folder_ / "disc.jpg", disc, 98);
  for (const int longer_px : {500, 400})
    for (const char* name : {"disc.png", "disc.jpg"}) {
      const Image8 part = ReadReducedTo(folder_ / name, 1, longer_px);
      double sum = 0, sum_x = 0, sum_y = 0;
      for (int y = 0; y < part.height; ++y)
        for (int x = 0; x < part.width; ++x) {
          const double weight = *part.at(x, y) > 127 ? 1 : 0;
          sum += weight, sum_x += weight * (x + 0.5), sum_y += weight * (y + 0.5);
        }
      EXPECT_NEAR(sum_x / sum * disc.width / part.width, 600, 0.2) << name;
      EXPECT_NEAR(sum_y / sum * disc.height / part.height, 400, 0.2) << name;
    }
}

TEST_F(ReducedFiles, DamagedFilesAreNamed) {
  const fs::path path = folder_ / "waves.jpg";
  WriteImage(path, Waves(200, 150));
  const std::string bytes = ReadFile(path);
  for (const std::size_t kept : {bytes.size() / 2, bytes.size() - 2, std::size_t{40}}) {
    WriteFile(path, bytes.substr(0, kept));
    try {
      ReadReduced(path, 3, 4);
      ADD_FAILURE() << kept << " bytes of " << bytes.size() << " were read as a whole picture";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("waves.jpg"), std::string::npos) << error.what();
    }
  }
  EXPECT_THROW(ReadReduced(folder_ / "none.jpg", 3, 4), DiskError);
  const fs::path mask = folder_ / "mask.png";
  WriteGreyMaskPng(mask, Image8(200, 150, 1, 255));
  const std::string whole = ReadFile(mask);
  WriteFile(mask, whole.substr(0, whole.size() - 20));
  EXPECT_THROW(ReadReduced(mask, 1, 4), InputError);
  EXPECT_THROW(ReadReducedTo(mask, 1, 120), InputError);
}

}  // namespace keypose::reduced_image_test
