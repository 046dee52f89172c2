#include "core/io/pictures/image_io.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "core/io/pictures/image_levels.h"
#include "core/io/testing/image_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/exif_focal.h"

namespace keypose::image_io_test {

Image8 Gradient(int width, int height) {
  Image8 image(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(255 * x / width);
      image.at(x, y)[1] = static_cast<std::uint8_t>(255 * y / height);
    }
  return image;
}

TEST_F(ImageIo, PngIsLossless) {
  WriteImage(folder_ / "g.png", Gradient(40, 30));
  EXPECT_EQ(ReadImage(folder_ / "g.png").data, Gradient(40, 30).data);
}

TEST_F(ImageIo, LinearLightIsWrittenAsTheExtensionAndBitsSay) {
  ImageF linear(8, 4, 3, 0.2140411f);  // sRGB 127.5
  linear.data[0] = 3;
  linear.data[1] = 0.001f;  // on the straight part of the curve: 12.92 * 0.001 * 255 = 3.29
  WriteLinearImage(folder_ / "l.png", linear);
  WriteLinearImage(folder_ / "l16.png", linear, 16);
  WriteLinearImage(folder_ / "l.tif", linear);
  WriteLinearImage(folder_ / "l.exr", linear, 32);
  for (const char* name : {"l.png", "l16.png", "l.tif"}) {
    const Image8 read = ReadImage(folder_ / name, 3);
    EXPECT_EQ(read.data[0], 255) << name;
    EXPECT_EQ(read.data[1], 3) << name;
    EXPECT_NEAR(read.data[2], 127.5, 0.6) << name;
  }
  EXPECT_EQ(ReadFile(folder_ / "l.png").at(24), 8);  // the depth in a PNG's header
  EXPECT_EQ(ReadFile(folder_ / "l16.png").at(24), 16);
  EXPECT_EQ(ReadFile(folder_ / "l.exr").substr(0, 4), "v/1\x01");
  EXPECT_THROW(WriteLinearImage(folder_ / "l.exr", linear, 8), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "l.png", linear, 32), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "l.jpg", linear), UsageError);
  EXPECT_THROW(WriteLinearImage(folder_ / "missing" / "l.exr", linear), DiskError);
}

TEST_F(ImageIo, LevelsOfSixteenBitsAreNotRounded) {
  ImageF levels(64, 2, 3);
  for (std::size_t i = 0; i < levels.data.size(); ++i)
    levels.data[i] = static_cast<float>(i * 171 % 65536) / 257;
  for (const char* name : {"deep.png", "deep.tif"}) {
    WriteLevels(folder_ / name, levels, 16);
    EXPECT_EQ(StoredLevelsOf(folder_ / name).bits, 16) << name;
    const ImageF read = ReadLevels(folder_ / name);
    for (std::size_t i = 0; i < levels.data.size(); ++i)
      ASSERT_NEAR(read.data[i], levels.data[i], 1e-4) << name;
  }
  WriteLevels(folder_ / "eight.png", levels, 8);
  EXPECT_EQ(StoredLevelsOf(folder_ / "eight.png").bits, 8);
  const ImageF whole = ReadLevels(folder_ / "eight.png");
  for (std::size_t i = 0; i < levels.data.size(); ++i)
    ASSERT_EQ(whole.data[i], std::round(levels.data[i]));
}

TEST_F(ImageIo, PhotographsOfSixteenBitsAreReadAsTheyAreStoredAndRoundedToEight) {
  Image16 deep(256, 256, 3);
  for (std::size_t i = 0; i < deep.data.size(); ++i)
    deep.data[i] = static_cast<std::uint16_t>(i / 3);
  for (const char* name : {"deep.png", "deep.tif"}) {
    WriteImage(folder_ / name, deep);
    const StoredPicture read = ReadAsStored(folder_ / name);
    EXPECT_TRUE(read.eight.empty());
    EXPECT_TRUE(read.sixteen.data == deep.data) << name;
    const Image8 rounded = ReadImage(folder_ / name, 3);
    for (std::size_t i = 0; i < deep.data.size(); ++i)
      ASSERT_EQ(rounded.data[i], std::lround(deep.data[i] / 257.0)) << name;
  }
  WriteImage(folder_ / "eight.png", Gradient(40, 30));
  EXPECT_EQ(ReadAsStored(folder_ / "eight.png").eight.data, Gradient(40, 30).data);
  EXPECT_TRUE(ReadAsStored(folder_ / "eight.png").sixteen.empty());
  WriteImage(folder_ / "deep.jpg", deep, 95);
  EXPECT_TRUE(ReadAsStored(folder_ / "deep.jpg").sixteen.empty()) << "JPEG has 8 bits";
}

TEST_F(ImageIo, GreyOfSixteenBitsBecomesThreeEqualChannels) {
  WriteLevels(folder_ / "grey.tif", ImageF(5, 3, 1, 100.5f), 16);
  EXPECT_EQ(ReadAsStored(folder_ / "grey.tif").sixteen.data, Image16(5, 3, 3, 25829).data);
}

TEST_F(ImageIo, SixteenBitsAreAveragedWhereTheyAreResized) {
  Image16 steps(4, 2, 1);
  for (std::size_t i = 0; i < 8; ++i) steps.data[i] = static_cast<std::uint16_t>(60000 + 10 * i);
  EXPECT_EQ(Resized(steps, 2, 1).data, (std::vector<std::uint16_t>{60025, 60045}));
}

TEST_F(ImageIo, LevelsAreNotMultipliedByAlpha) {
  ImageF levels(4, 4, 4, 200);
  for (std::size_t i = 3; i < levels.data.size(); i += 4) levels.data[i] = i % 8 == 3 ? 0 : 128;
  for (const int bits : {8, 16}) {
    WriteLevels(folder_ / "keyed.png", levels, bits);
    EXPECT_TRUE(StoredLevelsOf(folder_ / "keyed.png").alpha);
    for (const float level : ReadLevels(folder_ / "keyed.png").data) ASSERT_EQ(level, 200) << bits;
    EXPECT_EQ(ReadAlpha(folder_ / "keyed.png").data[1], 128);
  }
}

TEST_F(ImageIo, NoFileHoldsTheTimeOfDay) {
  const ImageF linear(8, 4, 3, 0.2f);
  const std::vector<std::string> kinds = {".png", ".tif", ".exr", ".jpg"};
  const auto write = [&](const std::string& kind) {
    const fs::path file = folder_ / ("time" + kind);
    if (kind == ".jpg")
      WriteImage(file, Gradient(8, 4));
    else
      WriteLinearImage(file, linear);
    return ReadFile(file);
  };
  std::vector<std::string> first;
  for (const std::string& kind : kinds) first.push_back(write(kind));
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // such times are whole seconds
  for (std::size_t k = 0; k < kinds.size(); ++k)
    EXPECT_EQ(write(kinds[k]) == first[k], true) << kinds[k];
}

TEST_F(ImageIo, ExifComesBackAndOrientationIsApplied) {
  const ExifToWrite exif{35, 52, "Maker", "Box 1", 6};
  WriteImage(folder_ / "g.jpg", Gradient(64, 32), 98, &exif);
  const ImageInfo info = ReadImageInfo(folder_ / "g.jpg");
  EXPECT_NEAR(info.focal_mm.value_or(0), 35, 1e-3);
  EXPECT_NEAR(info.focal_35mm.value_or(0), 52, 1e-3);
  EXPECT_EQ(info.camera_model, "Maker Box 1");
  EXPECT_EQ(info.width, 32);
  const Image8 image = ReadImage(folder_ / "g.jpg");
  ASSERT_EQ(image.width, 32);
  ASSERT_EQ(image.height, 64);
  // Orientation 6: the stored top row becomes the right-hand column, so red increases downwards and
  // green to the left.
  EXPECT_LT(image.at(16, 2)[0], image.at(16, 61)[0]);
  EXPECT_GT(image.at(2, 32)[1], image.at(29, 32)[1]);
}

TEST_F(ImageIo, PixelPitchTellsTheFocalLengthToAFraction) {
  ExifToWrite exif;
  exif.focal_mm = 40;
  exif.focal_35mm = 57.6888;  // which EXIF rounds
  WriteImage(folder_ / "a.jpg", Image8(100, 75, 3), 90, &exif);
  const ImageInfo info = ReadImageInfo(folder_ / "a.jpg");
  EXPECT_EQ(info.focal_35mm.value_or(0), 58);
  const double wanted = 57.6888 / kFilmDiagonal_mm * 125;
  EXPECT_NEAR(info.sensor_width_mm.value_or(0), 40 / wanted * 100, 1e-3);
  EXPECT_NEAR(FocalPx(100, 75, 58, 40, *info.sensor_width_mm), wanted, 1e-2);
  exif.focal_35mm = 58;
  WriteImage(folder_ / "b.jpg", Image8(100, 75, 3), 90, &exif);
  EXPECT_FALSE(ReadImageInfo(folder_ / "b.jpg").sensor_width_mm);
}

TEST_F(ImageIo, TruncatedJpegThrowsAndNamesTheFile) {
  WriteImage(folder_ / "g.jpg", Gradient(200, 150));
  const std::string bytes = ReadFile(folder_ / "g.jpg");
  Put("cut.jpg", bytes.substr(0, bytes.size() * 2 / 3));
  try {
    ReadImage(folder_ / "cut.jpg");
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cut.jpg"), std::string::npos);
  }
}

TEST_F(ImageIo, ResizingKeepsTheMean) {
  Image8 image(64, 64, 1);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x)
      *image.at(x, y) = static_cast<std::uint8_t>((x * 7 + y * 13) % 200);
  const auto mean = [](const Image8& i) {
    double sum = 0;
    for (const auto v : i.data) sum += v;
    return sum / static_cast<double>(i.data.size());
  };
  EXPECT_NEAR(mean(Resized(image, 16, 16)), mean(image), 0.5);
}

}  // namespace keypose::image_io_test
