#include "core/io/pictures/plain_texture.h"

#include <gtest/gtest.h>
#include <png.h>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/picture_bytes.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"

namespace keypose::plain_texture_test {

/// Each pixel another colour.
Image8 Colors() {
  Image8 image(6, 4, 3);
  for (std::size_t i = 0; i < image.data.size(); ++i)
    image.data[i] = static_cast<std::uint8_t>(37 * i);
  return image;
}

/// The colours with alpha from 0 to 253.
std::string PngWithAlpha() {
  const Image8 colors = Colors();
  std::string pixels;
  for (std::size_t i = 0; i < 24; ++i) {
    pixels.append(reinterpret_cast<const char*>(&colors.data[3 * i]), 3);
    pixels += static_cast<char>(11 * i);
  }
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 6;
  image.height = 4;
  image.format = PNG_FORMAT_RGBA;
  png_alloc_size_t size = 0;
  png_image_write_to_memory(&image, nullptr, &size, 0, pixels.data(), 0, nullptr);
  std::string bytes(size, '\0');
  png_image_write_to_memory(&image, bytes.data(), &size, 0, pixels.data(), 0, nullptr);
  return bytes.substr(0, size);
}

TEST(PlainTexture, ColoursOfAPngStayWhereItsAlphaHidesThem) {
  const std::string plain = PlainTexture(PngWithAlpha(), "skin", true);
  EXPECT_EQ(plain[25], 2) << "no alpha";
  EXPECT_EQ(DecodePicture(plain, "skin").data, Colors().data);
}

TEST(PlainTexture, AJpegIsNotTurned) {
  const TestingFolder folder;
  ExifToWrite exif;
  exif.orientation = 6;
  WriteImage(folder.path() / "skin.jpg", Colors(), 95, &exif);
  const std::string bytes = ReadFile(folder.path() / "skin.jpg");
  ASSERT_EQ(ReadImageInfo(folder.path() / "skin.jpg").width, 4) << "it lies across";
  EXPECT_EQ(ReadTexture(folder.path() / "skin.jpg").data, DecodePicture(bytes, "skin").data);
  const std::string plain = PlainTexture(bytes, "skin", true);
  EXPECT_LT(plain.size(), bytes.size());
  WriteFile(folder.path() / "plain.jpg", plain);
  EXPECT_EQ(ReadImageInfo(folder.path() / "plain.jpg").width, 6);
  EXPECT_EQ(DecodePicture(plain, "skin").data, DecodePicture(bytes, "skin").data)
      << "the same pixels";
}

TEST(PlainTexture, ProfilesAreTakenOutWhereTheyMustBeIgnored) {
  constexpr std::size_t kHead = 33, kSrgb = 13;
  const std::string bare = PngBytes(Colors()).erase(kHead, kSrgb);
  std::string png = bare;
  const std::string gamma = std::string("\0\0\0\4gAMA\0\0\xb1\x8f\x0b\xfc\x61\x05", 16);
  png.insert(kHead, gamma);
  EXPECT_EQ(PlainTexture(png, "skin", true), png);
  EXPECT_EQ(PlainTexture(png, "skin", false), bare);
  const std::string known = PngBytes(Colors()).insert(kHead, gamma);
  EXPECT_EQ(PlainTexture(known, "skin", false), known) << "sRGB, said twice";
}

TEST(PlainTexture, WhatIsPlainStaysAsItIs) {
  const TestingFolder folder;
  WriteImage(folder.path() / "skin.jpg", Colors());
  for (const std::string& bytes :
       {PngBytes(Colors()), std::string("no picture"), std::string(), PngWithAlpha().substr(0, 60)})
    EXPECT_EQ(PlainTexture(bytes, "skin", false), bytes);
}

}  // namespace keypose::plain_texture_test
