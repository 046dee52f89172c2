#include "core/io/pictures/heif_io.h"

#include <gtest/gtest.h>
#include <libheif/heif_cxx.h>

#include "core/io/pictures/image_io.h"
#include "core/io/testing/image_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::heif_io_test {

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

}  // namespace keypose::heif_io_test
