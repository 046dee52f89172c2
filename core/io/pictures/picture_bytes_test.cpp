#include "core/io/pictures/picture_bytes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <webp/encode.h>

#include <cstdlib>

#include "core/io/pictures/image_io.h"
#include "core/io/text/files.h"
#include "core/testing/folder.h"
#include "core/values/errors.h"

namespace keypose::picture_bytes_test {

using ::testing::HasSubstr;

Image8 Gradient() {
  Image8 image(40, 24, 3);
  for (int y = 0; y < 24; ++y)
    for (int x = 0; x < 40; ++x) {
      image.at(x, y)[0] = static_cast<std::uint8_t>(6 * x);
      image.at(x, y)[1] = static_cast<std::uint8_t>(10 * y);
      image.at(x, y)[2] = 77;
    }
  return image;
}

class PictureBytes : public ::testing::Test, public TestingFolder {};

TEST_F(PictureBytes, PngKeepsEachPixel) {
  EXPECT_EQ(DecodePicture(PngBytes(Gradient()), "a").data, Gradient().data);
  const Image8 grey(3, 2, 1, 99);
  EXPECT_EQ(DecodePicture(PngBytes(grey), "a").data, Image8(3, 2, 3, 99).data);
}

TEST_F(PictureBytes, WebpIsDecoded) {
  std::uint8_t* out = nullptr;
  const Image8 image = Gradient();
  const std::size_t size =
      WebPEncodeLosslessRGB(image.data.data(), image.width, image.height, 3 * image.width, &out);
  const std::string bytes(reinterpret_cast<char*>(out), size);
  WebPFree(out);
  EXPECT_EQ(PictureBytesKind(bytes), "webp");
  EXPECT_EQ(DecodePicture(bytes, "a").data, image.data);
  EXPECT_THROW(DecodePicture(bytes.substr(0, bytes.size() / 2), "a"), InputError);
}

TEST_F(PictureBytes, JpegIsDecodedAsOpenImageIoDoes) {
  WriteImage(folder_ / "a.jpg", Gradient(), 95);
  const std::string bytes = ReadFile(folder_ / "a.jpg");
  EXPECT_EQ(DecodePicture(bytes, "a").data, ReadImage(folder_ / "a.jpg", 3).data);
  EXPECT_THROW(DecodePicture(bytes.substr(0, bytes.size() / 2), "a"), InputError);
}

TEST_F(PictureBytes, OtherPicturesAreCalledWhatTheyAre) {
  for (const auto& [bytes, kind] : {std::pair<std::string, const char*>{"BM and so on", "BMP"},
                                    {"DDS and so on", "DDS"},
                                    {"\xabKTX 20\xbb", "KTX"},
                                    {"", "no PNG, JPEG or WebP"}})
    try {
      DecodePicture(bytes, "skin.tex");
      ADD_FAILURE() << kind;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), ::testing::AllOf(HasSubstr(kind), HasSubstr("skin.tex")));
    }
}

}  // namespace keypose::picture_bytes_test
