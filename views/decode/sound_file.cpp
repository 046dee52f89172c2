#include "views/decode/sound_file.h"

#include <fmt/format.h>

#include <cmath>

namespace keypose {
namespace {

constexpr double kJump_s = 0.03;

}  // namespace

SoundFile::SoundFile(const std::filesystem::path& path)
    : packet_(av_packet_alloc()), frame_(av_frame_alloc()) {
  av_log_set_level(AV_LOG_QUIET);
  AVFormatContext* opened = nullptr;
  AVDictionary* options = nullptr;
  av_dict_set(&options, "protocol_whitelist", "file", 0);
  const int code =
      avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &options);
  av_dict_free(&options);
  format_.reset(opened);
  if (code >= 0 && avformat_find_stream_info(format_.get(), nullptr) >= 0)
    FindSound();
  else
    fault_ = "is no film or sound, or is damaged";
}

void SoundFile::FindSound() {
  for (unsigned i = 0; i < format_->nb_streams; ++i) {
    AVStream* stream = format_->streams[i];
    const AVMediaType type = stream->codecpar->codec_type;
    if (!stream_ && type == AVMEDIA_TYPE_AUDIO) stream_ = stream;
    if (type == AVMEDIA_TYPE_VIDEO && !(stream->disposition & AV_DISPOSITION_ATTACHED_PIC))
      is_film_ = true;
    if (stream != stream_) stream->discard = AVDISCARD_ALL;
  }
  if (!stream_) {
    fault_ = "has no sound";
    return;
  }
  const AVCodec* codec = avcodec_find_decoder(stream_->codecpar->codec_id);
  AvEncoder decoder(codec ? avcodec_alloc_context3(codec) : nullptr);
  if (decoder) {
    avcodec_parameters_to_context(decoder.get(), stream_->codecpar);
    decoder->pkt_timebase = stream_->time_base;
    decoder->thread_count = 1;
    if (avcodec_open2(decoder.get(), codec, nullptr) >= 0) decoder_ = std::move(decoder);
  }
  if (!decoder_)
    fault_ = fmt::format("has sound of a kind without a decoder here ({})",
                         avcodec_get_name(stream_->codecpar->codec_id));
}

void SoundFile::SendPacket(const Progress* progress) {
  while (av_read_frame(format_.get(), packet_.get()) >= 0) {
    if (progress && progress->cancelled()) throw Cancelled();
    const bool mine = packet_->stream_index == stream_->index;
    if (mine && avcodec_send_packet(decoder_.get(), packet_.get()) < 0) ++faults_;
    av_packet_unref(packet_.get());
    if (mine) return;
  }
  avcodec_send_packet(decoder_.get(), nullptr);
  drained_ = true;
}

const AVFrame* SoundFile::Next(const Progress* progress) {
  while (decoder_) {
    const int code = avcodec_receive_frame(decoder_.get(), frame_.get());
    if (code >= 0 && frame_->sample_rate > 0 && frame_->nb_samples > 0) {
      TellTime();
      return frame_.get();
    }
    if (code == AVERROR_EOF || (drained_ && code < 0)) break;
    if (code >= 0) continue;
    if (code != AVERROR(EAGAIN)) ++faults_;
    SendPacket(progress);
  }
  return nullptr;
}

void SoundFile::TellTime() {
  if (frame_->best_effort_timestamp != AV_NOPTS_VALUE) {
    const double time_s =
        static_cast<double>(frame_->best_effort_timestamp) * av_q2d(stream_->time_base);
    if (!begun_ || std::abs(time_s - next_s_) > kJump_s) next_s_ = time_s;
  }
  begun_ = true;
  begin_s_ = next_s_;
  next_s_ += static_cast<double>(frame_->nb_samples) / frame_->sample_rate;
}

}  // namespace keypose
