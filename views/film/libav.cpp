#include "views/film/libav.h"

#include "core/values/errors.h"
#include "core/values/late_library.h"

namespace keypose {
namespace {

LateLibrary film_library("films", "read and write films and sound");

}  // namespace

void* FindInLibav(const char* function) { return film_library.Find(function); }

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

int AvFile::AddStream(const AVCodecContext& encoder) {
  AVStream* stream = avformat_new_stream(context_, nullptr);
  if (!stream) Encoded(AVERROR(ENOMEM));
  Encoded(avcodec_parameters_from_context(stream->codecpar, &encoder));
  stream->time_base = encoder.time_base;
  stream->avg_frame_rate = encoder.framerate;
  return stream->index;
}

void AvFile::Begin(const char* key, const char* value) {
  AVDictionary* options = nullptr;
  if (key) av_dict_set(&options, key, value, 0);
  const int code = avformat_write_header(context_, &options);
  av_dict_free(&options);
  Written(code);
}

void AvFile::Send(int stream, AVCodecContext& encoder, const AVFrame* frame,
                  std::int64_t duration) {
  Encoded(avcodec_send_frame(&encoder, frame));
  for (;;) {
    const int code = avcodec_receive_packet(&encoder, packet_.get());
    if (code == AVERROR(EAGAIN) || code == AVERROR_EOF) return;
    Encoded(code);
    if (duration > 0) packet_->duration = duration;
    av_packet_rescale_ts(packet_.get(), encoder.time_base, context_->streams[stream]->time_base);
    packet_->stream_index = stream;
    Written(av_interleaved_write_frame(context_, packet_.get()));
  }
}

void AvFile::End() {
  Written(av_write_trailer(context_));
  Written(avio_closep(&context_->pb));
}

}  // namespace keypose
