#include "views/film/gif.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/film/frame_painter.h"
#include "views/film/libav.h"
#include "views/film/palette.h"

namespace keypose {
namespace {

/// The palette's last entry stands for "as in the picture before".
constexpr int kTransparent = 255;
constexpr int kShortestHundredths = 2;

/// The parts of the old pixels that a new pixel covers.
struct Overlap {
  int first = 0;
  std::vector<double> shares;  ///< sum to 1
};

std::vector<Overlap> Overlaps(int from, int to) {
  std::vector<Overlap> overlaps(to);
  const double scale = static_cast<double>(from) / to;
  for (int i = 0; i < to; ++i) {
    const double begin = i * scale, end = std::min<double>(from, (i + 1) * scale);
    overlaps[i].first = static_cast<int>(begin);
    for (int at = overlaps[i].first; at < end; ++at)
      overlaps[i].shares.push_back((std::min(end, at + 1.0) - std::max<double>(begin, at)) / scale);
  }
  return overlaps;
}

/// A picture and when it begins, in hundredths of a second.
struct Timed {
  Image8 picture;
  std::int64_t begin = 0;
};

AvEncoder OpenGifEncoder(const AvFile& file, int width, int height) {
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_GIF);
  if (!codec) throw ToolError("film: libavcodec cannot write GIF; install Debian's libavcodec59");
  AvEncoder encoder(avcodec_alloc_context3(codec));
  encoder->width = width;
  encoder->height = height;
  encoder->pix_fmt = AV_PIX_FMT_PAL8;
  encoder->time_base = {1, 100};
  encoder->thread_count = 1;
  encoder->flags |= AV_CODEC_FLAG_BITEXACT;
  file.Encoded(avcodec_open2(encoder.get(), codec, nullptr));
  return encoder;
}

/// A frame that holds the palette.
AvFrame PaletteFrame(const AvFile& file, const AVCodecContext& encoder, const Palette& palette) {
  AvFrame frame(av_frame_alloc());
  frame->format = encoder.pix_fmt;
  frame->width = encoder.width;
  frame->height = encoder.height;
  file.Encoded(av_frame_get_buffer(frame.get(), 0));
  std::array<std::uint32_t, 256> argb;
  argb.fill(0xff000000u);
  for (std::size_t i = 0; i < palette.colors.size(); ++i)
    for (int k = 0; k < 3; ++k)
      argb[i] |= static_cast<std::uint32_t>(palette.colors[i][k]) << (16 - 8 * k);
  argb[kTransparent] = 0;
  std::copy(argb.begin(), argb.end(), reinterpret_cast<std::uint32_t*>(frame->data[1]));
  return frame;
}

}  // namespace

Image8 Shrunk(const Image8& picture, int width, int height) {
  if (width == picture.width && height == picture.height) return picture;
  const auto columns = Overlaps(picture.width, width), rows = Overlaps(picture.height, height);
  Image8 small(width, height, 3);
  ParallelFor(height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < width; ++x) {
      std::array<double, 3> sum{};
      for (int v = 0; v < SizeOf(rows[y].shares); ++v)
        for (int u = 0; u < SizeOf(columns[x].shares); ++u) {
          const std::uint8_t* rgb = picture.at(columns[x].first + u, rows[y].first + v);
          const double share = rows[y].shares[v] * columns[x].shares[u];
          for (int k = 0; k < 3; ++k) sum[k] += share * kLinearDouble[rgb[k]];
        }
      for (int k = 0; k < 3; ++k)
        small.at(x, y)[k] = static_cast<std::uint8_t>(
            std::lround(255 * SrgbFromLinear(std::clamp(sum[k], 0.0, 1.0))));
    }
  });
  return small;
}

struct GifWriter::State {
  AvFile file;
  double fps;
  GifOptions options;
  int width = 0, height = 0;  // of the pictures given
  std::int64_t count = 0;     // of the pictures given
  std::int64_t end = 0;       // hundredths
  bool shortened = false;
  Image8 latest;
  std::vector<Timed> pictures;
  ColorCounts colors;

  State(const std::string& path, double fps_, const GifOptions& o)
      : file(path, "gif"), fps(fps_), options(o) {}

  std::int64_t Hundredths(std::int64_t number) const {
    return std::llround(100 * static_cast<double>(number) / fps);
  }
  void CheckSize(const Image8& picture) {
    if (count == 0) {
      width = picture.width;
      height = picture.height;
    }
    if (picture.empty() || picture.width != width || picture.height != height)
      throw InputError("film: a picture of the GIF has " + std::to_string(picture.width) + " x " +
                       std::to_string(picture.height) + " pixels, the first had " +
                       std::to_string(width) + " x " + std::to_string(height));
  }
  void Write(AVCodecContext& encoder, AVFrame& frame, Ditherer& ditherer, std::size_t number) {
    const Image8 indices = ditherer.Indices(pictures[number].picture);
    file.Encoded(av_frame_make_writable(&frame));
    for (int y = 0; y < indices.height; ++y)
      std::copy_n(indices.at(0, y), indices.width, frame.data[0] + y * frame.linesize[0]);
    frame.pts = pictures[number].begin;
    const bool last = number + 1 == pictures.size();
    const std::int64_t next = last ? end : pictures[number + 1].begin;
    file.Send(0, encoder, &frame, next - pictures[number].begin);
  }
};

GifWriter::GifWriter(const std::filesystem::path& path, double fps, const GifOptions& options)
    : state_(std::make_unique<State>(path.string(), fps, options)) {}

GifWriter::~GifWriter() = default;

void GifWriter::Add(const Image8& picture) {
  State& s = *state_;
  s.CheckSize(picture);
  const std::int64_t begin = s.Hundredths(s.count);
  const bool late = static_cast<double>(s.count) >= s.options.max_seconds * s.fps && s.count > 0;
  s.shortened |= late;
  if (late) return;
  s.end = s.Hundredths(++s.count);
  if (picture.data == s.latest.data) return;
  if (!s.pictures.empty() && begin - s.pictures.back().begin < kShortestHundredths) return;
  s.latest = picture;
  const int height = std::min(picture.height, s.options.height);
  const int width = std::max(1, static_cast<int>(std::lround(static_cast<double>(picture.width) *
                                                             height / picture.height)));
  Image8 small = Shrunk(LaidOver(picture, kFilmBackground), width, height);
  s.colors.Add(small);
  s.pictures.push_back({std::move(small), begin});
}

void GifWriter::Finish() {
  State& s = *state_;
  if (s.pictures.empty()) throw InputError("film: a GIF needs at least one picture");
  const Image8& first = s.pictures[0].picture;
  const AvEncoder encoder = OpenGifEncoder(s.file, first.width, first.height);
  const Palette palette = s.colors.Choose(kTransparent);
  const AvFrame frame = PaletteFrame(s.file, *encoder, palette);
  Ditherer ditherer(palette);
  s.file.AddStream(*encoder);
  s.file.Begin(nullptr, nullptr);
  const std::int64_t last =
      std::max<std::int64_t>(kShortestHundredths, s.end - s.pictures.back().begin);
  s.file.Encoded(av_opt_set_int(s.file.context()->priv_data, "final_delay", last, 0));
  for (std::size_t i = 0; i < s.pictures.size(); ++i) s.Write(*encoder, *frame, ditherer, i);
  s.file.Send(0, *encoder, nullptr, 0);
  s.file.End();
}

bool GifWriter::Shortened() const { return state_->shortened; }

}  // namespace keypose
