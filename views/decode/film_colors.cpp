#include "views/decode/film_colors.h"

#include "views/film/late_libav.h"

#include <fmt/format.h>

#include <algorithm>

namespace keypose {
namespace {

const AVPixFmtDescriptor& FormatOf(const AVFrame& frame) {
  return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

bool IsRgb(const AVFrame& frame) {
  return (FormatOf(frame).flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0;
}

/// Shares of red and blue in luma.
struct LumaShares {
  double red, blue;
};
constexpr LumaShares kBt601{0.299, 0.114}, kBt709{0.2126, 0.0722}, kBt2020{0.2627, 0.0593},
    kFcc{0.30, 0.11}, kSmpte240{0.212, 0.087};

constexpr int kMostSdRows = 576, kMostSdColumns = 1279;

LumaShares SharesOf(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
      return kBt709;
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
      return kBt601;
    case AVCOL_SPC_BT2020_NCL:
      return kBt2020;
    case AVCOL_SPC_FCC:
      return kFcc;
    case AVCOL_SPC_SMPTE240M:
      return kSmpte240;
    default:
      return frame.height > kMostSdRows || frame.width > kMostSdColumns ? kBt709 : kBt601;
  }
}

bool IsFullRange(const AVFrame& frame) {
  switch (frame.format) {
    case AV_PIX_FMT_YUVJ420P:
    case AV_PIX_FMT_YUVJ422P:
    case AV_PIX_FMT_YUVJ440P:
    case AV_PIX_FMT_YUVJ444P:
    case AV_PIX_FMT_YUVJ411P:
      return true;
    default:
      return frame.color_range == AVCOL_RANGE_JPEG;
  }
}

std::string MatrixFault(const AVFrame& frame) {
  switch (frame.colorspace) {
    case AVCOL_SPC_BT709:
    case AVCOL_SPC_BT470BG:
    case AVCOL_SPC_SMPTE170M:
    case AVCOL_SPC_BT2020_NCL:
    case AVCOL_SPC_FCC:
    case AVCOL_SPC_SMPTE240M:
    case AVCOL_SPC_UNSPECIFIED:
    case AVCOL_SPC_RESERVED:
      return "";
    default:
      return fmt::format(
          "has colours by the matrix '{}', which is not read; convert it, as with ffmpeg's option "
          "-vf scale=out_color_matrix=bt709",
          av_color_space_name(frame.colorspace));
  }
}

std::string TransferFault(const AVFrame& frame) {
  constexpr const char* kCure =
      "film with HDR off, or convert it: ffmpeg -i FILM -vf "
      "zscale=t=linear:npl=203,format=gbrpf32le,zscale=p=bt709,tonemap=hable,zscale=t=bt709:m="
      "bt709:r=tv,format=yuv420p OTHER";
  switch (frame.color_trc) {
    case AVCOL_TRC_SMPTE2084:
      return fmt::format("is HDR (PQ, SMPTE ST 2084), which is not read; {}", kCure);
    case AVCOL_TRC_ARIB_STD_B67:
      return fmt::format("is HDR (HLG, ARIB STD-B67), which is not read; {}", kCure);
    case AVCOL_TRC_LINEAR:
    case AVCOL_TRC_LOG:
    case AVCOL_TRC_LOG_SQRT:
    case AVCOL_TRC_SMPTE428:
      return fmt::format(
          "has levels by the curve '{}', which is not read; convert it to BT.709, as with ffmpeg's "
          "option -vf zscale=t=bt709",
          av_color_transfer_name(frame.color_trc));
    default:
      return "";
  }
}

std::string FormatFault(const AVFrame& frame) {
  const AVPixFmtDescriptor& format = FormatOf(frame);
  const bool xyz = frame.format == AV_PIX_FMT_XYZ12LE || frame.format == AV_PIX_FMT_XYZ12BE;
  constexpr std::uint64_t kUnread =
      AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_BAYER | AV_PIX_FMT_FLAG_FLOAT;
  if (!xyz && (format.flags & kUnread) == 0) return "";
  return fmt::format(
      "has pixels of the kind '{}', which is not read; convert it to H.264, or to numbered "
      "pictures",
      format.name);
}

}  // namespace

YuvWeights WeightsOf(const AVFrame& frame) {
  const LumaShares shares = SharesOf(frame);
  const int depth = FormatOf(frame).comp[0].depth;
  const double step = 1 << (depth - 8), most = (1 << depth) - 1;
  const double green = 1 - shares.red - shares.blue;
  YuvWeights weights;
  const bool full = IsFullRange(frame);
  weights.black = full ? 0 : 16 * step;
  weights.middle = 128 * step;
  weights.scale = 255 / (full ? most : 219 * step);
  weights.chroma_scale = 255 / (full ? most : 224 * step);
  weights.r_of_v = 2 * (1 - shares.red);
  weights.b_of_u = 2 * (1 - shares.blue);
  weights.g_of_u = -shares.blue / green * weights.b_of_u;
  weights.g_of_v = -shares.red / green * weights.r_of_v;
  return weights;
}

std::string ColorFault(const AVFrame& frame) {
  if (const std::string fault = FormatFault(frame); !fault.empty()) return fault;
  if (const std::string fault = TransferFault(frame); !fault.empty()) return fault;
  if (!IsRgb(frame)) return MatrixFault(frame);
  if (frame.color_range != AVCOL_RANGE_MPEG) return "";
  return "has RGB of limited range, which is not read; convert it to full range, as with ffmpeg's "
         "option -vf scale=in_range=tv:out_range=pc";
}

std::string ColorNote(const AVFrame& frame) {
  switch (frame.color_primaries) {
    case AVCOL_PRI_BT2020:
    case AVCOL_PRI_SMPTE431:
    case AVCOL_PRI_SMPTE432:
      return fmt::format(
          "has the wide colours of '{}', which are taken for sRGB's and so look paler",
          av_color_primaries_name(frame.color_primaries));
    default:
      return "";
  }
}

}  // namespace keypose
