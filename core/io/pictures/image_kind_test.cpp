#include "core/io/pictures/image_kind.h"

#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/testing/damaged_file.h"
#include "core/io/testing/image_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::image_kind_test {

namespace fs = std::filesystem;

using HostileImage = HostileFile;

TEST_F(HostileImage, WhatIsNoPhotographByItsBytesIsNotReadWhateverItsName) {
  // the mark of a DirectDraw surface, and no picture behind it
  EXPECT_TRUE(Says(ImageMessage(Put("surface.jpg", "DDS " + std::string(124, '\0'))),
                   "whatever its name says"));
  ImageMessage(Put("text.png", "no picture"));
  ImageMessage(Put("gif.jpg", "GIF89a" + std::string(100, '\0')));
  ImageMessage(Put("short.jpg", "\xff"));
  ImageMessage(Put("soft.tif", "v/1\x01" + std::string(100, '\0')));
}

TEST_F(HostileImage, WhatIsWrongWithAPhotographIsToldBeforeItIsDecoded) {
  const std::string whole = ReadFile(PutJpeg("whole.jpg"));
  EXPECT_EQ(PhotographFault(whole), "");
  EXPECT_EQ(PhotographFault(whole.substr(0, whole.size() / 2)),
            "is cut off: its end is missing; copy it again");
  EXPECT_EQ(PhotographFault(""), "is empty");
  EXPECT_TRUE(PhotographFault("no picture").starts_with("is no picture that can be read (.jpg"));
  EXPECT_TRUE(PhotographFault("<!DOCTYPE html>").starts_with("is a web page, whatever its name"));
}

TEST_F(HostileImage, PhotographUnderAnotherKindsNameIsRead) {
  fs::rename(PutJpeg("photo.jpg"), folder_ / "photo.png");
  EXPECT_EQ(ReadImageInfo(folder_ / "photo.png").format, "jpeg");
  EXPECT_EQ(ReadImage(folder_ / "photo.png").width, 320);
}

TEST_F(HostileImage, HeicWhosePictureHasAnotherSizeThanItClaimsIsDamaged) {
  const fs::path photo = folder_ / "photo.heic";
  WriteImage(photo, Image8(64, 48, 3, 90));
  EXPECT_EQ(ReadImage(photo).width, 64);
  std::string bytes = ReadFile(photo);
  for (std::size_t at = bytes.find("ispe"); at != std::string::npos;
       at = bytes.find("ispe", at + 4))
    bytes.replace(at + 8, 4, BigEndian32(48));  // fewer columns than there are
  const fs::path narrow = Put("narrow.heic", bytes);
  EXPECT_TRUE(Says(Message<InputError>(narrow, [&] { ReadImage(narrow, 3); }),
                   "does not have the size that its container says"));
}

/// The first bytes of a PNG whose header claims this size.
std::string PngOf(std::uint32_t width, std::uint32_t height) {
  // libpng checks the checksum of the header: CRC-32, computed bit by bit.
  const std::string header =
      "IHDR" + BigEndian32(width) + BigEndian32(height) + std::string("\x08\x02\x00\x00\x00", 5);
  std::uint32_t crc = ~0u;
  for (const char c : header) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  return "\x89PNG\r\n\x1a\n" + BigEndian32(13) + header + BigEndian32(~crc);
}

TEST_F(HostileImage, ClaimedSizesBeyondTheLimitTakeNoMemory) {
  const std::string data = BigEndian32(16) + "IDAT" + std::string(20, '\0') + BigEndian32(0) +
                           "IEND" + std::string(4, '\0');
  const std::int64_t growth = GrowthBytes([&] {
    EXPECT_TRUE(Says(ImageMessage(Put("giant.png", PngOf(20000, 15000) + data)), "20000 x 15000"));
    EXPECT_TRUE(Says(ImageMessage(Put("giants.png", PngOf(50000, 50000) + data)), "50000 x 50000"));
    // claims a little more than the file has
    const std::string chunk = BigEndian32(1000) + "eXIf" + std::string(40, '\0');
    EXPECT_TRUE(Says(ImageMessage(Put("chunk.png", PngOf(64, 16) + chunk + data)),
                     "is truncated or damaged"));
    std::string claim = "....ftypheic....mif1heic", box = BigEndian32(20) + "ispe" +
                                                          BigEndian32(0) + BigEndian32(20000) +
                                                          BigEndian32(20000);
    claim.replace(0, 4, BigEndian32(24));
    EXPECT_TRUE(Says(ImageMessage(Put("giant.heic", claim + box)), "claims more"));
  });
  EXPECT_LT(growth, 100 << 20);
  EXPECT_GT(ClaimedHeifPixels(BigEndian32(20) + "ispe" + BigEndian32(0) + BigEndian32(0xffffffff) +
                              BigEndian32(0xffffffff)),
            kMostPixels);
  EXPECT_EQ(ReadImage(PutJpeg("strip.jpg", 1, 20000)).height,
            20000);  // unusual, but a valid picture
}

TEST_F(HostileImage, ThumbnailsEndMarkDoesNotStandForThePhotographs) {
  const std::string photo = ReadFile(PutJpeg("photo.jpg")),
                    thumbnail = ReadFile(PutJpeg("thumbnail.jpg", 64, 48));
  ASSERT_LT(thumbnail.size(), 60000u);
  const std::string segment = "Exif" + std::string(2, '\0') + thumbnail;
  const std::string with = photo.substr(0, 2) + "\xff\xe1" +
                           BigEndian32(static_cast<std::uint32_t>(segment.size() + 2)).substr(2) +
                           segment + photo.substr(2);
  EXPECT_EQ(ReadImage(Put("with.jpg", with)).data, ReadImage(folder_ / "photo.jpg").data);
  const std::string cut = with.substr(0, with.size() - photo.size() / 3);
  ASSERT_LT(cut.size(), 65536u) << "the thumbnail's mark must lie where the end is looked for";
  const fs::path path = Put("cut.jpg", cut);
  EXPECT_TRUE(Says(Message<InputError>(path, [&] { ReadImage(path); }), "truncated"));
  EXPECT_TRUE(IsWholeImage(with + "what a camera adds", "jpeg"));
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

}  // namespace keypose::image_kind_test
