#include "views/film/mp4.h"

#include <optional>

#include "core/values/errors.h"
#include "views/film/frame_painter.h"
#include "views/film/libav.h"
#include "views/film/sound_encoder.h"

namespace keypose {
namespace {

/// x264's quality scale; lower is better. A high quality, since clay has fine grain and films are
/// short.
constexpr const char* kQuality = "18";

const AVCodec* H264Encoder() { return avcodec_find_encoder_by_name("libx264"); }

}  // namespace

bool CanWriteMp4() { return H264Encoder() != nullptr; }

struct Mp4Writer::State {
  AvFile file;
  AvEncoder encoder;
  AvFrame frame;
  SwsContext* scaler = nullptr;
  std::int64_t count = 0;
  int stream = -1;
  double fps = 0;
  std::optional<SoundEncoder> sound;

  explicit State(const std::string& path) : file(path, "mp4") {}
  ~State() { sws_freeContext(scaler); }

  void OpenEncoder(int width, int height) {
    const AVCodec* codec = H264Encoder();
    if (!codec)
      throw ToolError(
          "film: libavcodec has no x264; install Debian's libavcodec-extra or libavcodec59, or "
          "leave `video` out of `formats`");
    encoder.reset(avcodec_alloc_context3(codec));
    encoder->width = width;
    encoder->height = height;
    encoder->pix_fmt = AV_PIX_FMT_YUV420P;
    encoder->framerate = av_d2q(fps, 1 << 16);
    encoder->time_base = av_inv_q(encoder->framerate);
    encoder->thread_count = 1;
    encoder->color_primaries = AVCOL_PRI_BT709;
    encoder->color_trc = AVCOL_TRC_BT709;
    encoder->colorspace = AVCOL_SPC_BT709;
    encoder->color_range = AVCOL_RANGE_MPEG;
    encoder->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
    file.Encoded(av_opt_set(encoder->priv_data, "crf", kQuality, 0));
    file.Encoded(avcodec_open2(encoder.get(), codec, nullptr));
  }

  void OpenScaler() {
    frame.reset(av_frame_alloc());
    frame->format = encoder->pix_fmt;
    frame->width = encoder->width;
    frame->height = encoder->height;
    file.Encoded(av_frame_get_buffer(frame.get(), 0));
    scaler = sws_getContext(
        encoder->width, encoder->height, AV_PIX_FMT_RGB24, encoder->width, encoder->height,
        encoder->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr);
    if (!scaler) throw ToolError("film: libswscale cannot convert RGB to 4:2:0");
    const int* rgb = sws_getCoefficients(SWS_CS_DEFAULT);
    sws_setColorspaceDetails(scaler, rgb, 1, sws_getCoefficients(SWS_CS_ITU709), 0, 0, 1 << 16,
                             1 << 16);
  }
};

Mp4Writer::Mp4Writer(const std::filesystem::path& path, int width, int height, double fps,
                     Sound sound)
    : state_(std::make_unique<State>(path.string())) {
  state_->fps = fps;
  state_->OpenEncoder(width, height);
  state_->stream = state_->file.AddStream(*state_->encoder);
  if (sound.length() > 0) state_->sound.emplace(&state_->file, std::move(sound));
  state_->file.Begin("movflags", "+faststart");
  state_->OpenScaler();
}

Mp4Writer::~Mp4Writer() = default;

void Mp4Writer::Add(const Image8& picture) {
  State& s = *state_;
  if (picture.width != s.encoder->width || picture.height != s.encoder->height)
    throw InputError("film: a picture of the film has " + std::to_string(picture.width) + " x " +
                     std::to_string(picture.height) + " pixels, the film has " +
                     std::to_string(s.encoder->width) + " x " + std::to_string(s.encoder->height));
  const Image8 flat = LaidOver(picture, kFilmBackground);
  s.file.Encoded(av_frame_make_writable(s.frame.get()));
  const std::uint8_t* rows[] = {flat.data.data()};
  const int stride[] = {3 * flat.width};
  sws_scale(s.scaler, rows, stride, 0, flat.height, s.frame->data, s.frame->linesize);
  s.frame->pts = s.count++;
  s.file.Send(s.stream, *s.encoder, s.frame.get(), 1);
  if (s.sound) s.sound->WriteUntil(static_cast<double>(s.count) / s.fps);
}

void Mp4Writer::Finish() {
  State& s = *state_;
  s.file.Send(s.stream, *s.encoder, nullptr, 1);
  if (s.sound) s.sound->FinishAt(static_cast<double>(s.count) / s.fps);
  s.file.End();
}

}  // namespace keypose
