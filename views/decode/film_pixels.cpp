#include "views/decode/film_pixels.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <vector>

#include "core/numbers/parallel.h"
#include "views/decode/film_colors.h"
#include "views/film/late_libav.h"

namespace keypose {
namespace {

constexpr int kRowsTogether = 64;

const AVPixFmtDescriptor& FormatOf(const AVFrame& frame) {
  return *av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
}

int Halved(int length, int shift) { return -((-length) >> shift); }

/// To the nearest. Whole numbers are clamped, since comparisons of others make no vectors.
std::uint8_t Rounded(float value) {
  const int whole = static_cast<int>(value + 0.5F), high = whole > 255 ? 255 : whole;
  return static_cast<std::uint8_t>(high < 0 ? 0 : high);
}

/// Rows of one component of a frame, as numbers.
class Component {
 public:
  Component(const AVFrame& frame, int component)
      : frame_(frame), format_(FormatOf(frame)), component_(component) {
    const bool chroma = (component == 1 || component == 2) && format_.nb_components > 2 &&
                        (format_.flags & AV_PIX_FMT_FLAG_RGB) == 0;
    width_ = chroma ? Halved(frame.width, format_.log2_chroma_w) : frame.width;
    height_ = chroma ? Halved(frame.height, format_.log2_chroma_h) : frame.height;
  }
  int width() const { return width_; }
  int height() const { return height_; }

  void Row(int y, std::vector<float>* row) const {
    row->resize(static_cast<std::size_t>(width_));
    if (IsPlain(1)) return Copy<std::uint8_t>(y, row);
    if (IsPlain(2)) return Copy<std::uint16_t>(y, row);
    std::vector<std::uint16_t> values(row->size());
    Line(y, values.data());
    std::copy(values.begin(), values.end(), row->begin());
  }
  /// Scaled to 0..255, rounded to the nearest.
  void Row8(int y, std::vector<std::uint8_t>* row) const {
    row->resize(static_cast<std::size_t>(width_));
    if ((format_.flags & AV_PIX_FMT_FLAG_PAL) != 0) return OfPalette(y, row);
    std::vector<std::uint16_t> values(row->size());
    Line(y, values.data());
    const int most = (1 << format_.comp[component_].depth) - 1;
    const bool inverted = frame_.format == AV_PIX_FMT_MONOWHITE;
    for (std::size_t x = 0; x < values.size(); ++x) {
      const int value = inverted ? most - values[x] : values[x];
      (*row)[x] = static_cast<std::uint8_t>((value * 255 + most / 2) / most);
    }
  }

 private:
  /// Numbers of so many bytes, one after the other, as this machine has them.
  bool IsPlain(int bytes) const {
    const AVComponentDescriptor& c = format_.comp[component_];
    const bool big = (format_.flags & AV_PIX_FMT_FLAG_BE) != 0;
    return c.step == bytes && c.shift == 0 && (bytes == 1 || !big) &&
           (bytes == 1) == (c.depth <= 8) &&
           (format_.flags & (AV_PIX_FMT_FLAG_BITSTREAM | AV_PIX_FMT_FLAG_PAL)) == 0 &&
           std::endian::native == std::endian::little;
  }
  template <class T>
  void Copy(int y, std::vector<float>* row) const {
    const AVComponentDescriptor& c = format_.comp[component_];
    const T* from = reinterpret_cast<const T*>(
        frame_.data[c.plane] + static_cast<std::ptrdiff_t>(y) * frame_.linesize[c.plane] +
        c.offset);
    float* __restrict to = row->data();
    for (int x = 0; x < width_; ++x) to[x] = from[x];
  }
  /// Palettes hold 32 bits a colour: alpha in the highest, then red, green, blue.
  void OfPalette(int y, std::vector<std::uint8_t>* row) const {
    constexpr int kShift[] = {16, 8, 0, 24};
    const std::uint8_t* index =
        frame_.data[0] + static_cast<std::ptrdiff_t>(y) * frame_.linesize[0];
    for (std::size_t x = 0; x < row->size(); ++x) {
      std::uint32_t color = 0;
      std::memcpy(&color, frame_.data[1] + 4 * index[x], sizeof color);
      (*row)[x] = static_cast<std::uint8_t>(color >> kShift[component_]);
    }
  }
  void Line(int y, std::uint16_t* values) const {
    const std::uint8_t* planes[4] = {frame_.data[0], frame_.data[1], frame_.data[2],
                                     frame_.data[3]};
    av_read_image_line2(values, planes, frame_.linesize, &format_, 0, y, component_, width_, 0,
                        sizeof(std::uint16_t));
  }

  const AVFrame& frame_;
  const AVPixFmtDescriptor& format_;
  int component_, width_ = 0, height_ = 0;
};

/// Where colour lies that is stored for fewer pixels than there are.
struct ChromaPlace {
  int shift_x, shift_y;
  bool middle_x, middle_y;  ///< between pixels, else at the first of them
};

ChromaPlace PlaceOf(const AVFrame& frame) {
  const AVPixFmtDescriptor& format = FormatOf(frame);
  const AVChromaLocation at = frame.chroma_location;
  const bool middle =
      at == AVCHROMA_LOC_CENTER || at == AVCHROMA_LOC_TOP || at == AVCHROMA_LOC_BOTTOM;
  const bool top = at == AVCHROMA_LOC_TOPLEFT || at == AVCHROMA_LOC_TOP;
  return {format.log2_chroma_w, format.log2_chroma_h, middle, !top};
}

/// One colour component, for any row of the picture.
class Chroma {
 public:
  Chroma(const AVFrame& frame, int component, const ChromaPlace& place)
      : component_(frame, component), place_(place) {}

  void Row(int y, int width, std::vector<float>* row) {
    if (place_.shift_y == 0)
      component_.Row(y, &narrow_);
    else
      MixRows(y);
    Widen(width, row);
  }

 private:
  /// A place of the picture in the component's own pixels.
  static double PlaceIn(int at, int shift, bool middle) {
    const double step = 1 << shift;
    return middle ? (at + 0.5) / step - 0.5 : at / step;
  }
  void MixRows(int y) {
    const double at = PlaceIn(y, place_.shift_y, place_.middle_y);
    const int last = component_.height() - 1;
    const int above = std::clamp(static_cast<int>(std::floor(at)), 0, last);
    const int below = std::min(static_cast<int>(std::floor(at)) + 1, last);
    const float share = static_cast<float>(at - std::floor(at));
    component_.Row(above, &narrow_);
    component_.Row(below, &below_);
    float* __restrict to = narrow_.data();
    const float* __restrict other = below_.data();
    for (std::size_t x = 0; x < narrow_.size(); ++x) to[x] += share * (other[x] - to[x]);
  }
  void Widen(int width, std::vector<float>* row) {
    row->resize(static_cast<std::size_t>(width));
    if (place_.shift_x == 0)
      *row = narrow_;
    else if (place_.shift_x == 1 && !place_.middle_x)
      Double(width, row);
    else
      WidenAnyhow(width, row);
  }
  void Double(int width, std::vector<float>* row) {
    narrow_.push_back(narrow_.back());
    const float* __restrict from = narrow_.data();
    float* __restrict to = row->data();
    for (int x = 0; x < width / 2; ++x) {
      to[2 * x] = from[x];
      to[2 * x + 1] = 0.5F * (from[x] + from[x + 1]);
    }
    if (width % 2 == 1) to[width - 1] = from[width / 2];
  }
  void WidenAnyhow(int width, std::vector<float>* row) {
    const int last = component_.width() - 1;
    for (int x = 0; x < width; ++x) {
      const double at = PlaceIn(x, place_.shift_x, place_.middle_x);
      const int left = static_cast<int>(std::floor(at));
      const float a = narrow_[static_cast<std::size_t>(std::clamp(left, 0, last))],
                  b = narrow_[static_cast<std::size_t>(std::clamp(left + 1, 0, last))];
      (*row)[static_cast<std::size_t>(x)] = a + static_cast<float>(at - left) * (b - a);
    }
  }

  Component component_;
  ChromaPlace place_;
  std::vector<float> narrow_, below_;
};

/// A row's colours; each row of these lies apart, so that the compiler makes vectors of it.
struct ColorRows {
  std::vector<std::uint8_t> red, green, blue;
};

/// As YuvWeights, in single precision.
struct RowWeights {
  explicit RowWeights(const YuvWeights& w)
      : scale(static_cast<float>(w.scale)),
        black(static_cast<float>(w.black * w.scale)),
        middle(static_cast<float>(w.middle)),
        r_of_v(static_cast<float>(w.r_of_v * w.chroma_scale)),
        g_of_u(static_cast<float>(w.g_of_u * w.chroma_scale)),
        g_of_v(static_cast<float>(w.g_of_v * w.chroma_scale)),
        b_of_u(static_cast<float>(w.b_of_u * w.chroma_scale)) {}
  float scale, black, middle, r_of_v, g_of_u, g_of_v, b_of_u;
};

void MixRow(const RowWeights w, std::size_t width, const float* __restrict luma,
            const float* __restrict u, const float* __restrict v, std::uint8_t* __restrict red,
            std::uint8_t* __restrict green, std::uint8_t* __restrict blue) {
  for (std::size_t x = 0; x < width; ++x) {
    const float grey = w.scale * luma[x] - w.black, cu = u[x] - w.middle, cv = v[x] - w.middle;
    red[x] = Rounded(grey + w.r_of_v * cv);
    green[x] = Rounded(grey + w.g_of_u * cu + w.g_of_v * cv);
    blue[x] = Rounded(grey + w.b_of_u * cu);
  }
}

void Mix(const YuvWeights& weights, const std::vector<float>& luma, const std::vector<float>& u,
         const std::vector<float>& v, ColorRows* colors) {
  const std::size_t width = luma.size();
  colors->red.resize(width), colors->green.resize(width), colors->blue.resize(width);
  MixRow(RowWeights(weights), width, luma.data(), u.data(), v.data(), colors->red.data(),
         colors->green.data(), colors->blue.data());
}

template <int kChannels>
void Interleave(const ColorRows& colors, std::uint8_t* __restrict to) {
  const std::uint8_t *__restrict red = colors.red.data(), *__restrict green = colors.green.data(),
                     *__restrict blue = colors.blue.data();
  const std::size_t width = colors.red.size();
  for (std::size_t x = 0; x < width; ++x) {
    to[kChannels * x] = red[x];
    to[kChannels * x + 1] = green[x];
    to[kChannels * x + 2] = blue[x];
  }
}

/// Monochrome films of codecs for television have its range; pictures have all levels. Their
/// decoders say so.
void GreyRows(const AVFrame& frame, int y, ColorRows* colors) {
  if (frame.color_range != AVCOL_RANGE_MPEG) {
    Component(frame, 0).Row8(y, &colors->red);
  } else {
    const YuvWeights weights = WeightsOf(frame);
    std::vector<float> grey;
    Component(frame, 0).Row(y, &grey);
    const std::vector<float> none(grey.size(), static_cast<float>(weights.middle));
    return Mix(weights, grey, none, none, colors);
  }
  colors->green = colors->blue = colors->red;
}

void RgbRows(const AVFrame& frame, int y, ColorRows* colors) {
  Component(frame, 0).Row8(y, &colors->red);
  Component(frame, 1).Row8(y, &colors->green);
  Component(frame, 2).Row8(y, &colors->blue);
}

int AlphaComponent(const AVFrame& frame) {
  const AVPixFmtDescriptor& format = FormatOf(frame);
  return (format.flags & AV_PIX_FMT_FLAG_PAL) != 0 ? 3 : format.nb_components - 1;
}

void PutAlpha(const AVFrame& frame, int y, std::uint8_t* to) {
  std::vector<std::uint8_t> alpha(static_cast<std::size_t>(frame.width), 255);
  if (HasAlpha(frame)) Component(frame, AlphaComponent(frame)).Row8(y, &alpha);
  for (std::size_t x = 0; x < alpha.size(); ++x) to[4 * x + 3] = alpha[x];
}

/// Colours of consecutive rows.
class RowReader {
 public:
  explicit RowReader(const AVFrame& frame)
      : frame_(frame),
        weights_(WeightsOf(frame)),
        place_(PlaceOf(frame)),
        luma_of_(frame, 0),
        u_of_(frame, std::min(1, FormatOf(frame).nb_components - 1), place_),
        v_of_(frame, std::min(2, FormatOf(frame).nb_components - 1), place_) {}

  const ColorRows& Row(int y) {
    const AVPixFmtDescriptor& format = FormatOf(frame_);
    if ((format.flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0) {
      RgbRows(frame_, y, &colors_);
    } else if (format.nb_components < 3) {
      GreyRows(frame_, y, &colors_);
    } else {
      luma_of_.Row(y, &luma_);
      u_of_.Row(y, frame_.width, &u_);
      v_of_.Row(y, frame_.width, &v_);
      Mix(weights_, luma_, u_, v_, &colors_);
    }
    return colors_;
  }

 private:
  const AVFrame& frame_;
  YuvWeights weights_;
  ChromaPlace place_;
  Component luma_of_;
  Chroma u_of_, v_of_;
  std::vector<float> luma_, u_, v_;
  ColorRows colors_;
};

}  // namespace

bool HasAlpha(const AVFrame& frame) {
  return (FormatOf(frame).flags & (AV_PIX_FMT_FLAG_ALPHA | AV_PIX_FMT_FLAG_PAL)) != 0;
}

Image8 PixelsOf(const AVFrame& frame, int channels) {
  Image8 image(frame.width, frame.height, channels);
  const int parts = (frame.height + kRowsTogether - 1) / kRowsTogether;
  ParallelFor(parts, [&](std::int64_t part) {
    RowReader reader(frame);
    const int first = static_cast<int>(part) * kRowsTogether,
              end = std::min(first + kRowsTogether, frame.height);
    for (int y = first; y < end; ++y) {
      std::uint8_t* to = image.at(0, y);
      if (channels == 3) {
        Interleave<3>(reader.Row(y), to);
      } else {
        Interleave<4>(reader.Row(y), to);
        PutAlpha(frame, y, to);
      }
    }
  });
  return image;
}

}  // namespace keypose
