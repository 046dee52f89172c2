#include "export/film/mp4.h"

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libswscale/swscale.h>
}

#include "core/errors.h"

namespace keypose::exporting {
namespace {

/// x264's quality scale; lower is better. A high quality, since clay has fine grain and films are
/// short.
constexpr const char* kQuality = "18";

std::string TextOf(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE];
  return av_strerror(code, text, sizeof text) == 0 ? text : "error " + std::to_string(code);
}

const AVCodec* Encoder() { return avcodec_find_encoder_by_name("libx264"); }

template <class T, void (*Free)(T**)>
struct Freer {
  void operator()(T* pointer) const { Free(&pointer); }
};

}  // namespace

bool CanWriteMp4() { return Encoder() != nullptr; }

struct Mp4Writer::State {
  std::string path;
  std::unique_ptr<AVCodecContext, Freer<AVCodecContext, avcodec_free_context>> encoder;
  std::unique_ptr<AVFrame, Freer<AVFrame, av_frame_free>> frame;
  std::unique_ptr<AVPacket, Freer<AVPacket, av_packet_free>> packet;
  AVFormatContext* file = nullptr;
  SwsContext* scaler = nullptr;
  AVStream* stream = nullptr;
  std::int64_t count = 0;

  ~State() {
    sws_freeContext(scaler);
    if (file && file->pb) avio_closep(&file->pb);
    avformat_free_context(file);
  }

  void Encoded(int code) const {
    if (code < 0) throw ToolError("export: x264 could not encode " + path + ": " + TextOf(code));
  }
  void Written(int code) const {
    if (code < 0) throw DiskError("export: cannot write " + path + ": " + TextOf(code));
  }

  void OpenEncoder(int width, int height, double fps) {
    const AVCodec* codec = Encoder();
    if (!codec)
      throw ToolError(
          "export: libavcodec has no x264; install Debian's libavcodec-extra or libavcodec59, or "
          "turn `video` off");
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
    Encoded(av_opt_set(encoder->priv_data, "crf", kQuality, 0));
    Encoded(avcodec_open2(encoder.get(), codec, nullptr));
  }

  void OpenFile() {
    Written(avformat_alloc_output_context2(&file, nullptr, "mp4", path.c_str()));
    file->flags |= AVFMT_FLAG_BITEXACT;  // no time and no version in the header
    stream = avformat_new_stream(file, nullptr);
    Encoded(avcodec_parameters_from_context(stream->codecpar, encoder.get()));
    stream->time_base = encoder->time_base;
    stream->avg_frame_rate = encoder->framerate;
    Written(avio_open(&file->pb, path.c_str(), AVIO_FLAG_WRITE));
    AVDictionary* options = nullptr;
    av_dict_set(&options, "movflags", "+faststart", 0);
    const int code = avformat_write_header(file, &options);
    av_dict_free(&options);
    Written(code);
  }

  void OpenScaler() {
    frame.reset(av_frame_alloc());
    frame->format = encoder->pix_fmt;
    frame->width = encoder->width;
    frame->height = encoder->height;
    Encoded(av_frame_get_buffer(frame.get(), 0));
    packet.reset(av_packet_alloc());
    scaler = sws_getContext(
        encoder->width, encoder->height, AV_PIX_FMT_RGB24, encoder->width, encoder->height,
        encoder->pix_fmt, SWS_BICUBIC | SWS_ACCURATE_RND | SWS_BITEXACT, nullptr, nullptr, nullptr);
    if (!scaler) throw ToolError("export: libswscale cannot convert RGB to 4:2:0 for " + path);
    const int* rgb = sws_getCoefficients(SWS_CS_DEFAULT);
    sws_setColorspaceDetails(scaler, rgb, 1, sws_getCoefficients(SWS_CS_ITU709), 0, 0, 1 << 16,
                             1 << 16);
  }

  /// @param picture  nullptr: no more pictures
  void Send(const AVFrame* picture) {
    Encoded(avcodec_send_frame(encoder.get(), picture));
    for (;;) {
      const int code = avcodec_receive_packet(encoder.get(), packet.get());
      if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
      Encoded(code);
      packet->duration = 1;
      av_packet_rescale_ts(packet.get(), encoder->time_base, stream->time_base);
      packet->stream_index = stream->index;
      Written(av_interleaved_write_frame(file, packet.get()));
    }
  }
};

Mp4Writer::Mp4Writer(const std::filesystem::path& path, int width, int height, double fps)
    : state_(std::make_unique<State>()) {
  av_log_set_level(AV_LOG_ERROR);
  state_->path = path.string();
  state_->OpenEncoder(width, height, fps);
  state_->OpenFile();
  state_->OpenScaler();
}

Mp4Writer::~Mp4Writer() = default;

void Mp4Writer::Add(const Image8& picture) {
  State& s = *state_;
  if (picture.channels != 3 || picture.width != s.encoder->width ||
      picture.height != s.encoder->height)
    throw InputError("export: a picture of the film is not RGB of " +
                     std::to_string(s.encoder->width) + " x " + std::to_string(s.encoder->height));
  s.Encoded(av_frame_make_writable(s.frame.get()));
  const std::uint8_t* rows[] = {picture.data.data()};
  const int stride[] = {3 * picture.width};
  sws_scale(s.scaler, rows, stride, 0, picture.height, s.frame->data, s.frame->linesize);
  s.frame->pts = s.count++;
  s.Send(s.frame.get());
}

void Mp4Writer::Finish() {
  State& s = *state_;
  s.Send(nullptr);
  s.Written(av_write_trailer(s.file));
  s.Written(avio_closep(&s.file->pb));
}

}  // namespace keypose::exporting
