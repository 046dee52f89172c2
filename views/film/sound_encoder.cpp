#include "views/film/sound_encoder.h"

#include <algorithm>
#include <cmath>

#include "core/values/errors.h"

namespace keypose {
namespace {

constexpr std::int64_t kBitsPerSecond = 192000;

std::int64_t SamplesBefore(double seconds) { return std::llround(seconds * kSoundRate); }

}  // namespace

SoundEncoder::SoundEncoder(AvFile* file, Sound sound) : file_(file), sound_(std::move(sound)) {
  const AVCodec* codec = avcodec_find_encoder(AV_CODEC_ID_AAC);
  if (!codec) throw ToolError("film: libavcodec has no encoder for sound as AAC");
  encoder_.reset(avcodec_alloc_context3(codec));
  encoder_->sample_fmt = AV_SAMPLE_FMT_FLTP;
  encoder_->sample_rate = kSoundRate;
  encoder_->time_base = {1, kSoundRate};
  encoder_->bit_rate = kBitsPerSecond;
  encoder_->thread_count = 1;
  encoder_->flags |= AV_CODEC_FLAG_GLOBAL_HEADER | AV_CODEC_FLAG_BITEXACT;
  av_channel_layout_default(&encoder_->ch_layout, 2);
  file_->Encoded(avcodec_open2(encoder_.get(), codec, nullptr));
  block_.reset(av_frame_alloc());
  block_->format = encoder_->sample_fmt;
  block_->nb_samples = encoder_->frame_size;
  block_->sample_rate = kSoundRate;
  file_->Encoded(av_channel_layout_copy(&block_->ch_layout, &encoder_->ch_layout));
  file_->Encoded(av_frame_get_buffer(block_.get(), 0));
  stream_ = file_->AddStream(*encoder_);
}

void SoundEncoder::Write(std::int64_t end) {
  file_->Encoded(av_frame_make_writable(block_.get()));
  block_->nb_samples = static_cast<int>(end - written_);
  block_->pts = written_;
  for (int c = 0; c < 2; ++c) {
    float* channel = reinterpret_cast<float*>(block_->extended_data[c]);
    for (std::int64_t i = written_; i < end; ++i)
      channel[i - written_] = sound_.samples[static_cast<std::size_t>(2 * i + c)];
  }
  file_->Send(stream_, *encoder_, block_.get(), 0);
  written_ = end;
}

void SoundEncoder::WriteUntil(double seconds) {
  const std::int64_t end = std::min(SamplesBefore(seconds), sound_.length());
  while (written_ + encoder_->frame_size <= end) Write(written_ + encoder_->frame_size);
}

void SoundEncoder::FinishAt(double seconds) {
  WriteUntil(seconds);
  const std::int64_t end = std::min(SamplesBefore(seconds), sound_.length());
  if (written_ < end) Write(end);
  file_->Send(stream_, *encoder_, nullptr, 0);
}

}  // namespace keypose
