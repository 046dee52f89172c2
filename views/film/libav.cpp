#include "views/film/libav.h"

#include "core/values/errors.h"

namespace keypose {

std::string AvText(int code) {
  char text[AV_ERROR_MAX_STRING_SIZE];
  return av_strerror(code, text, sizeof text) == 0 ? text : "error " + std::to_string(code);
}

void AvFile::Encoded(int code) const {
  if (code < 0) throw ToolError("film: libavcodec cannot encode " + path_ + ": " + AvText(code));
}

void AvFile::Written(int code) const {
  if (code < 0) throw DiskError("film: cannot write " + path_ + ": " + AvText(code));
}

AvFile::AvFile(const std::string& path, const char* format)
    : path_(path), packet_(av_packet_alloc()) {
  av_log_set_level(AV_LOG_ERROR);
  Written(avformat_alloc_output_context2(&context_, nullptr, format, path.c_str()));
  context_->flags |= AVFMT_FLAG_BITEXACT;  // no time and no version in the header
  const int code = avio_open(&context_->pb, path.c_str(), AVIO_FLAG_WRITE);
  if (code >= 0) return;
  avformat_free_context(context_);  // the destructor does not run
  Written(code);
}

AvFile::~AvFile() {
  if (context_->pb) avio_closep(&context_->pb);
  avformat_free_context(context_);
}

void AvFile::Begin(const AVCodecContext& encoder, const char* key, const char* value) {
  stream_ = avformat_new_stream(context_, nullptr);
  Encoded(avcodec_parameters_from_context(stream_->codecpar, &encoder));
  stream_->time_base = encoder.time_base;
  stream_->avg_frame_rate = encoder.framerate;
  AVDictionary* options = nullptr;
  if (key) av_dict_set(&options, key, value, 0);
  const int code = avformat_write_header(context_, &options);
  av_dict_free(&options);
  Written(code);
}

void AvFile::Send(AVCodecContext& encoder, const AVFrame* picture, std::int64_t duration) {
  Encoded(avcodec_send_frame(&encoder, picture));
  for (;;) {
    const int code = avcodec_receive_packet(&encoder, packet_.get());
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    Encoded(code);
    packet_->duration = duration;
    av_packet_rescale_ts(packet_.get(), encoder.time_base, stream_->time_base);
    packet_->stream_index = stream_->index;
    Written(av_interleaved_write_frame(context_, packet_.get()));
  }
}

void AvFile::End() {
  Written(av_write_trailer(context_));
  Written(avio_closep(&context_->pb));
}

}  // namespace keypose
