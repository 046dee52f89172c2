// Colours as worked out by hand from the equations of BT.601, BT.709 and BT.2020.
#include "views/decode/film_pixels.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

extern "C" {
#include <libavutil/pixdesc.h>
}

#include <array>
#include <cstring>

#include "views/decode/film_colors.h"
#include "views/film/libav.h"

namespace keypose::film_pixels_test {

using ::testing::HasSubstr;

AvFrame NewFrame(AVPixelFormat format, int width = 16, int height = 8) {
  AvFrame frame(av_frame_alloc());
  frame->format = format;
  frame->width = width;
  frame->height = height;
  av_frame_get_buffer(frame.get(), 0);
  for (const AVBufferRef* buffer : frame->buf)
    if (buffer) std::memset(buffer->data, 0, buffer->size);
  return frame;
}

/// Sets all of a component, of a frame that holds 0.
void Fill(AVFrame& frame, int component, int value) {
  const AVPixFmtDescriptor* format = av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  const bool chroma = component == 1 || component == 2;
  const bool yuv = (format->flags & AV_PIX_FMT_FLAG_RGB) == 0;
  const int width = chroma && yuv ? frame.width >> format->log2_chroma_w : frame.width,
            height = chroma && yuv ? frame.height >> format->log2_chroma_h : frame.height;
  const std::vector<std::uint16_t> row(static_cast<std::size_t>(width),
                                       static_cast<std::uint16_t>(value));
  for (int y = 0; y < height; ++y)
    av_write_image_line2(row.data(), frame.data, frame.linesize, format, 0, y, component, width,
                         sizeof row[0]);
}

AvFrame Yuv(AVPixelFormat format, int y, int u, int v) {
  AvFrame frame = NewFrame(format);
  Fill(*frame, 0, y), Fill(*frame, 1, u), Fill(*frame, 2, v);
  return frame;
}

using Rgb = std::array<int, 3>;

Rgb ColorOf(const AVFrame& frame) {
  const Image8 image = PixelsOf(frame, 3);
  const std::uint8_t* color = image.at(5, 3);
  return {color[0], color[1], color[2]};
}

struct Case {
  AVColorSpace matrix;
  AVColorRange range;
  std::array<int, 3> yuv;
  Rgb rgb;
};

TEST(PixelsOf, MatrixAndRangeAreTheFramesOwn) {
  const Case cases[] = {{AVCOL_SPC_SMPTE170M, AVCOL_RANGE_MPEG, {140, 118, 47}, {15, 214, 124}},
                        {AVCOL_SPC_BT470BG, AVCOL_RANGE_MPEG, {81, 90, 240}, {254, 0, 0}},
                        {AVCOL_SPC_SMPTE170M, AVCOL_RANGE_JPEG, {140, 118, 47}, {26, 201, 122}},
                        {AVCOL_SPC_SMPTE170M, AVCOL_RANGE_JPEG, {81, 90, 240}, {238, 14, 14}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, {140, 118, 47}, {0, 190, 123}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, {81, 90, 240}, {255, 24, 0}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_UNSPECIFIED, {140, 118, 47}, {0, 190, 123}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_JPEG, {140, 118, 47}, {12, 180, 121}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_JPEG, {235, 128, 128}, {235, 235, 235}},
                        {AVCOL_SPC_BT709, AVCOL_RANGE_MPEG, {235, 128, 128}, {255, 255, 255}},
                        {AVCOL_SPC_BT2020_NCL, AVCOL_RANGE_MPEG, {140, 118, 47}, {8, 199, 123}},
                        {AVCOL_SPC_BT2020_NCL, AVCOL_RANGE_JPEG, {81, 90, 240}, {246, 23, 10}}};
  for (const Case& one : cases) {
    AvFrame frame = Yuv(AV_PIX_FMT_YUV420P, one.yuv[0], one.yuv[1], one.yuv[2]);
    frame->colorspace = one.matrix;
    frame->color_range = one.range;
    EXPECT_EQ(ColorFault(*frame), "");
    EXPECT_EQ(ColorOf(*frame), one.rgb) << one.matrix << " " << one.range << " " << one.yuv[0];
  }
}

TEST(PixelsOf, AMatrixThatIsNotSaidIsByTheSize) {
  AvFrame small = NewFrame(AV_PIX_FMT_YUV420P, 720, 576),
          large = NewFrame(AV_PIX_FMT_YUV420P, 1280, 720);
  for (AVFrame* frame : {small.get(), large.get()})
    Fill(*frame, 0, 140), Fill(*frame, 1, 118), Fill(*frame, 2, 47);
  EXPECT_EQ(ColorOf(*small), (Rgb{15, 214, 124}));
  EXPECT_EQ(ColorOf(*large), (Rgb{0, 190, 123}));
}

TEST(PixelsOf, LayoutsAndDepthsGiveTheSameColor) {
  for (const AVPixelFormat format :
       {AV_PIX_FMT_YUV422P, AV_PIX_FMT_YUV444P, AV_PIX_FMT_NV12, AV_PIX_FMT_YUYV422,
        AV_PIX_FMT_UYVY422, AV_PIX_FMT_YUV411P, AV_PIX_FMT_YUVA420P}) {
    AvFrame frame = Yuv(format, 140, 118, 47);
    frame->colorspace = AVCOL_SPC_BT709;
    EXPECT_EQ(ColorOf(*frame), (Rgb{0, 190, 123})) << av_get_pix_fmt_name(format);
  }
  for (const AVPixelFormat format : {AV_PIX_FMT_YUV420P10LE, AV_PIX_FMT_YUV422P10BE,
                                     AV_PIX_FMT_YUV444P10LE, AV_PIX_FMT_P010LE}) {
    AvFrame frame = Yuv(format, 560, 472, 188);
    frame->colorspace = AVCOL_SPC_BT709;
    EXPECT_EQ(ColorOf(*frame), (Rgb{0, 190, 123})) << av_get_pix_fmt_name(format);
  }
}

TEST(PixelsOf, ColorBetweenItsPlacesIsInterpolated) {
  AvFrame frame = NewFrame(AV_PIX_FMT_YUV422P, 6, 2);
  Fill(*frame, 0, 128), Fill(*frame, 1, 128);
  for (int y = 0; y < 2; ++y)
    for (const int x : {0, 1, 2}) frame->data[2][y * frame->linesize[2] + x] = x == 0 ? 128 : 148;
  frame->colorspace = AVCOL_SPC_SMPTE170M;
  frame->color_range = AVCOL_RANGE_JPEG;
  const auto reds = [&] {
    const Image8 image = PixelsOf(*frame, 3);
    std::vector<int> all;
    for (int x = 0; x < 6; ++x) all.push_back(*image.at(x, 1));
    return all;
  };
  // 1.402 V: 20 levels are 28.04, 10 are 14.02, 5 are 7.01, 15 are 21.03.
  EXPECT_EQ(reds(), (std::vector<int>{128, 142, 156, 156, 156, 156})) << "at the first of two";
  frame->chroma_location = AVCHROMA_LOC_CENTER;
  EXPECT_EQ(reds(), (std::vector<int>{128, 135, 149, 156, 156, 156})) << "between two";
}

TEST(PixelsOf, RgbAndAlphaAreExact) {
  for (const AVPixelFormat format : {AV_PIX_FMT_RGBA, AV_PIX_FMT_ARGB, AV_PIX_FMT_BGRA,
                                     AV_PIX_FMT_GBRAP, AV_PIX_FMT_RGBA64BE, AV_PIX_FMT_GBRAP12LE}) {
    const int most = (1 << av_pix_fmt_desc_get(format)->comp[0].depth) - 1;
    for (int value = 0; value < 256; ++value) {
      AvFrame frame = NewFrame(format);
      for (int c = 0; c < 4; ++c) Fill(*frame, c, ((value + 60 * c) % 256 * most + 127) / 255);
      const Image8 image = PixelsOf(*frame, 4);
      for (int c = 0; c < 4; ++c)
        ASSERT_EQ(image.at(7, 2)[c], (value + 60 * c) % 256) << av_get_pix_fmt_name(format);
    }
    EXPECT_TRUE(HasAlpha(*NewFrame(format)));
  }
}

TEST(PixelsOf, AlphaOfColorDifferencesIsKeptToTheBit) {
  for (const AVPixelFormat format : {AV_PIX_FMT_YUVA420P, AV_PIX_FMT_YUVA444P10LE,
                                     AV_PIX_FMT_YUVA444P12LE, AV_PIX_FMT_YUVA422P}) {
    const int most = (1 << av_pix_fmt_desc_get(format)->comp[3].depth) - 1;
    for (int value = 0; value < 256; ++value) {
      AvFrame frame = NewFrame(format);
      Fill(*frame, 3, (value * most + 127) / 255);
      ASSERT_EQ(PixelsOf(*frame, 4).at(7, 2)[3], value) << av_get_pix_fmt_name(format);
    }
  }
  EXPECT_EQ(PixelsOf(*Yuv(AV_PIX_FMT_YUV420P, 1, 2, 3), 4).at(0, 0)[3], 255);
}

TEST(PixelsOf, PalettesAndGrey) {
  AvFrame palette = NewFrame(AV_PIX_FMT_PAL8);
  for (int y = 0; y < 8; ++y) palette->data[0][y * palette->linesize[0] + 5] = 7;
  reinterpret_cast<std::uint32_t*>(palette->data[1])[7] = 0x80102030;
  const Image8 image = PixelsOf(*palette, 4);
  EXPECT_THAT(std::vector<int>(image.at(5, 3), image.at(5, 3) + 4),
              ::testing::ElementsAre(0x10, 0x20, 0x30, 0x80));
  AvFrame grey = NewFrame(AV_PIX_FMT_GRAY8);
  Fill(*grey, 0, 235);
  EXPECT_EQ(ColorOf(*grey), (Rgb{235, 235, 235}));
  grey->color_range = AVCOL_RANGE_MPEG;
  EXPECT_EQ(ColorOf(*grey), (Rgb{255, 255, 255}));
}

TEST(ColorFault, NamesWhatIsNotRead) {
  AvFrame frame = NewFrame(AV_PIX_FMT_YUV420P);
  const auto transfer = [&](AVColorTransferCharacteristic curve) {
    frame->color_trc = curve;
    return ColorFault(*frame);
  };
  EXPECT_THAT(transfer(AVCOL_TRC_SMPTE2084), HasSubstr("HDR (PQ"));
  EXPECT_THAT(transfer(AVCOL_TRC_ARIB_STD_B67), HasSubstr("HDR (HLG"));
  EXPECT_THAT(transfer(AVCOL_TRC_LINEAR), HasSubstr("'linear'"));
  for (const auto curve : {AVCOL_TRC_BT709, AVCOL_TRC_SMPTE170M, AVCOL_TRC_IEC61966_2_1,
                           AVCOL_TRC_BT2020_10, AVCOL_TRC_UNSPECIFIED})
    EXPECT_EQ(transfer(curve), "");
  for (const auto matrix : {AVCOL_SPC_YCGCO, AVCOL_SPC_BT2020_CL, AVCOL_SPC_ICTCP}) {
    frame->colorspace = matrix;
    EXPECT_THAT(ColorFault(*frame), HasSubstr(av_color_space_name(matrix)));
  }
  AvFrame rgb = NewFrame(AV_PIX_FMT_RGB24);
  EXPECT_EQ(ColorFault(*rgb), "");
  rgb->color_range = AVCOL_RANGE_MPEG;
  EXPECT_THAT(ColorFault(*rgb), HasSubstr("limited range"));
  EXPECT_THAT(ColorFault(*NewFrame(AV_PIX_FMT_GBRPF32LE)), HasSubstr("gbrpf32le"));
}

}  // namespace keypose::film_pixels_test
