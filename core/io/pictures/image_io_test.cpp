#include <gtest/gtest.h>
#include <libheif/heif_cxx.h>

#include <chrono>
#include <cmath>
#include <thread>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::image_io_test {

/// A HEIC photograph of 128 x 80 pixels as it was taken, with a red upper left quarter. Like a
/// phone, it stores its orientation twice: in the container (irot), which decoders apply, and in
/// EXIF. The size is one that the library's HEIC writer can take.
fs::path PutHeic(const fs::path& path, int orientation) {
  Image8 image(128, 80, 3, 30);
  for (int y = 0; y < 40; ++y)
    for (int x = 0; x < 60; ++x) image.at(x, y)[0] = 220;
  ExifToWrite exif;
  exif.focal_mm = 4.2;
  exif.focal_35mm = 26;
  exif.make = "Apple";
  exif.model = "iPhone 12";
  exif.orientation = orientation;
  const fs::path plain = path.string() + ".plain.heic";
  WriteImage(plain, image, 92, &exif);
  heif::Context from, to;
  from.read_from_file(plain.string());
  heif::ImageHandle handle = from.get_primary_image_handle();
  heif::Encoder encoder(heif_compression_HEVC);
  heif::Context::EncodingOptions options;
  options.image_orientation = static_cast<heif_orientation>(orientation);
  heif::ImageHandle turned = to.encode_image(
      handle.decode_image(heif_colorspace_RGB, heif_chroma_interleaved_RGB), encoder, options);
  for (const heif_item_id id : handle.get_list_of_metadata_block_IDs("Exif")) {
    const std::vector<std::uint8_t> block = handle.get_metadata(id);
    // The first four bytes are the offset of the TIFF header, which the writer adds itself.
    to.add_exif_metadata(turned, block.data() + 4, SizeOf(block) - 4);
  }
  to.write_to_file(path.string());
  return path;
}

/// Whether the pixel belongs to the red quarter. Not for pixels near its edge, because HEIC is
/// lossy.
bool IsRed(const Image8& image, int x, int y) { return image.at(x, y)[0] > 150; }

class ImageIo : public ::testing::Test, public TestingFolder {};

TEST_F(ImageIo, HeicIsTurnedOnceAndKeepsItsFocalLength) {
  const fs::path path =
      PutHeic(folder_ / "portrait.heic", 6);  // to be shown rotated by 90 degrees clockwise
  const ImageInfo info = ReadImageInfo(path);
  EXPECT_EQ(info.format, "heif");
  EXPECT_EQ(info.width, 80);
  EXPECT_EQ(info.height, 128);
  EXPECT_EQ(info.orientation, 1) << "the decoder has turned it: nobody may turn it again";
  ASSERT_TRUE(info.focal_35mm);
  EXPECT_DOUBLE_EQ(*info.focal_35mm, 26);
  EXPECT_NEAR(info.focal_mm.value_or(0), 4.2, 1e-3);
  EXPECT_EQ(info.camera_model, "Apple iPhone 12");
  const Image8 image = ReadImage(path, 3);
  ASSERT_EQ(image.width, 80);
  ASSERT_EQ(image.height, 128);
  EXPECT_TRUE(IsRed(image, 60, 20))
      << "what was upper left is upper right after a turn to the right";
  EXPECT_FALSE(IsRed(image, 20, 20));
  EXPECT_FALSE(IsRed(image, 60, 100));
}

TEST_F(ImageIo, UprightHeicStaysAsItIs) {
  const Image8 image = ReadImage(PutHeic(folder_ / "landscape.heic", 1), 3);
  ASSERT_EQ(image.width, 128);
  EXPECT_TRUE(IsRed(image, 20, 20));
  EXPECT_FALSE(IsRed(image, 100, 20));
}

TEST_F(ImageIo, TruncatedHeicIsAnInputErrorThatNamesIt) {
  const std::string bytes = ReadFile(PutHeic(folder_ / "whole.heic", 1));
  const fs::path cut = Put("cut.heic", bytes.substr(0, bytes.size() / 2));
  try {
    ReadImage(cut, 3);
    FAIL() << "half a file was read";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cut.heic"), std::string::npos) << error.what();
  }
}

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

TEST_F(ImageIo, PicturesOfOtherFormatsAreCalledWhatTheyAre) {
  const std::vector<std::pair<std::string, std::string>> others = {
      {std::string("RIFF\x24\0\0\0WEBPVP8 ", 16), "a WebP picture"},
      {"BM6\x04", "a BMP picture"},
      {"P6\n4 4\n255\n", "a PPM, PGM or PBM picture"},
      {std::string("\0\0\0\x1c"
                   "ftypavif\0\0\0\0avifmif1",
                   24),
       "an AVIF picture"},
      {std::string("\0\0\0\x14"
                   "ftypqt  \0\0\0\0qt  ",
                   20),
       "a video"},
      {"<!DOCTYPE html><html>", "a web page"}};
  const auto told = [&](const std::string& bytes) -> std::string {
    const fs::path file = folder_ / "of_another_kind.jpg";
    WriteFile(file, bytes + std::string(60, '\0'));
    try {
      ReadImage(file, 3);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  for (const auto& [bytes, kind] : others) {
    EXPECT_NE(told(bytes).find("it is " + kind + ", and no JPEG, PNG, TIFF or HEIC file"),
              std::string::npos)
        << told(bytes);
    EXPECT_NE(told(bytes).find("save it as JPEG or PNG"), std::string::npos);
  }
  EXPECT_NE(told("RIFF, but no picture").find("it is no JPEG"), std::string::npos);
  EXPECT_NE(told("P6").find("it is no JPEG"), std::string::npos);
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
