#include "core/io/pictures/picture_pages.h"

#include <OpenImageIO/imageio.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/pictures/image_io.h"
#include "core/io/testing/image_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::picture_pages_test {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using std::string_literals::operator""s;

class PicturePages : public ImageIo {
 protected:
  struct Page {
    int side = 0, kind = 0;  ///< kind: NewSubfileType
  };
  fs::path WriteTiff(const std::vector<Page>& pages) const {
    const fs::path path = folder_ / "pages.tif";
    std::vector<OIIO::ImageSpec> specs;
    for (const Page& page : pages) {
      specs.emplace_back(page.side, page.side, 3, OIIO::TypeDesc::UINT8);
      if (page.kind != 0) specs.back().attribute("tiff:subfiletype", page.kind);
    }
    auto out = OIIO::ImageOutput::create("tiff");
    EXPECT_TRUE(out->open(path.string(), static_cast<int>(specs.size()), specs.data()));
    for (std::size_t i = 0; i < specs.size(); ++i) {
      if (i > 0) out->open(path.string(), specs[i], OIIO::ImageOutput::AppendSubimage);
      const std::vector<std::uint8_t> pixels(
          static_cast<std::size_t>(3 * specs[i].width * specs[i].height),
          static_cast<std::uint8_t>(50 + 10 * i));
      EXPECT_TRUE(out->write_image(OIIO::TypeDesc::UINT8, pixels.data()));
    }
    out->close();
    return path;
  }
  static std::string Fault(const fs::path& path) {
    try {
      ReadImage(path);
    } catch (const InputError& error) {
      return error.what();
    }
    return "none";
  }
};

TEST_F(PicturePages, APreviewOrAMaskBehindATiffIsNoPage) {
  EXPECT_EQ(ReadImage(WriteTiff({{40, 0}, {10, 0}})).data[0], 50);
  EXPECT_EQ(ReadImage(WriteTiff({{40, 0}})).data[0], 50);
}

TEST_F(PicturePages, ATiffOfPagesIsRefusedWithTheirNumber) {
  EXPECT_THAT(Fault(WriteTiff({{40, 0}, {40, 0}, {40, 0}})), HasSubstr("a TIFF of 3 pages"));
  // a preview before the picture
  EXPECT_THAT(Fault(WriteTiff({{10, 0}, {40, 0}})), HasSubstr("a TIFF of 2 pages"));
}

TEST_F(PicturePages, AnAnimatedPngIsRefusedWithItsNumber) {
  const fs::path path = folder_ / "g.png";
  WriteImage(path, Image8(4, 4, 3));
  std::string bytes = ReadFile(path);
  EXPECT_EQ(PngFrames(bytes), 1);
  // Behind the signature and the header of 25 bytes; no reader of one picture looks at its sum.
  bytes.insert(33,
               "\0\0\0\x08"
               "acTL\0\0\0\x05\0\0\0\0\0\0\0\0"s);
  EXPECT_EQ(PngFrames(bytes), 5);
  WriteFile(path, bytes);
  EXPECT_THAT(Fault(path), HasSubstr("an animated PNG of 5 pictures"));
}

TEST_F(PicturePages, AnimatedWebpIsKnownByItsFlag) {
  EXPECT_TRUE(IsAnimatedWebp("RIFF\x10\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0"s));
  EXPECT_FALSE(IsAnimatedWebp("RIFF\x10\0\0\0WEBPVP8X\x0a\0\0\0\x10\0\0\0"s));
  EXPECT_FALSE(IsAnimatedWebp("RIFF\x10\0\0\0WEBPVP8 "s));
}

}  // namespace keypose::picture_pages_test
