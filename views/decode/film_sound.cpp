#include "views/decode/film_sound.h"

extern "C" {
#include <libavutil/samplefmt.h>
}

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/values/size_of.h"
#include "views/decode/film_file.h"

namespace keypose {
namespace {

constexpr double kJump_s = 0.03;  // containers round times; what differs by more is a gap
constexpr double kMillis = 1000;

/// Power summed by milliseconds from the first sample on.
class MilliSums {
 public:
  explicit MilliSums(double most_s) : most_s_(most_s) {}

  /// What is no number, or lies elsewhere by a wrong time stamp, is left out.
  void Add(double time_s, double square) {
    if (!(square <= std::numeric_limits<float>::max())) return;
    if (sums_.empty()) first_s_ = time_s;
    const double at = (time_s - first_s_) * kMillis;
    if (!(at >= 0 && at < most_s_ * kMillis)) return;
    const std::size_t milli = static_cast<std::size_t>(at + 1e-6);
    if (milli >= sums_.size()) sums_.resize(milli + 1), counts_.resize(milli + 1);
    sums_[milli] += square;
    ++counts_[milli];
  }
  bool EndsBefore(double time_s) const { return !sums_.empty() && time_s - first_s_ > most_s_; }
  FilmSound Means() const {
    FilmSound sound{first_s_, {}};
    for (std::size_t i = 0; i < sums_.size(); ++i)
      sound.per_milli.push_back(static_cast<float>(counts_[i] > 0 ? sums_[i] / counts_[i] : 0));
    return sound;
  }

 private:
  double most_s_, first_s_ = 0;
  std::vector<double> sums_;
  std::vector<int> counts_;
};

/// A sample of channel c, as in [-1, 1].
template <class T>
double Sample(const AVFrame& frame, int c, int i) {
  const bool planar = av_sample_fmt_is_planar(static_cast<AVSampleFormat>(frame.format)) != 0;
  const int channels = frame.ch_layout.nb_channels;
  const T value = planar ? reinterpret_cast<const T*>(frame.extended_data[c])[i]
                         : reinterpret_cast<const T*>(frame.extended_data[0])[i * channels + c];
  if constexpr (std::is_floating_point_v<T>) return static_cast<double>(value);
  if constexpr (std::is_unsigned_v<T>) return (value - 128.0) / 128;
  return static_cast<double>(value) / -static_cast<double>(std::numeric_limits<T>::min());
}

using Sampler = double (*)(const AVFrame&, int, int);

Sampler SamplerOf(const AVFrame& frame) {
  switch (av_get_packed_sample_fmt(static_cast<AVSampleFormat>(frame.format))) {
    case AV_SAMPLE_FMT_U8:
      return Sample<std::uint8_t>;
    case AV_SAMPLE_FMT_S16:
      return Sample<std::int16_t>;
    case AV_SAMPLE_FMT_S32:
      return Sample<std::int32_t>;
    case AV_SAMPLE_FMT_S64:
      return Sample<std::int64_t>;
    case AV_SAMPLE_FMT_FLT:
      return Sample<float>;
    case AV_SAMPLE_FMT_DBL:
      return Sample<double>;
    default:
      return nullptr;
  }
}

class SoundReader {
 public:
  SoundReader(const std::filesystem::path& path, double zero_s)
      : packet_(av_packet_alloc()), frame_(av_frame_alloc()), zero_s_(zero_s) {
    av_log_set_level(AV_LOG_QUIET);
    AVFormatContext* opened = nullptr;
    AVDictionary* options = nullptr;
    av_dict_set(&options, "protocol_whitelist", "file", 0);
    const int code =
        avformat_open_input(&opened, ("file:" + path.string()).c_str(), nullptr, &options);
    av_dict_free(&options);
    format_.reset(opened);
    if (code >= 0 && avformat_find_stream_info(format_.get(), nullptr) >= 0) FindSound();
  }

  FilmSound Read(double most_s, const Progress* progress) {
    MilliSums sums(most_s);
    while (decoder_ && av_read_frame(format_.get(), packet_.get()) >= 0) {
      if (progress && progress->cancelled()) throw Cancelled();
      const bool mine = packet_->stream_index == stream_->index;
      if (mine) avcodec_send_packet(decoder_.get(), packet_.get());
      av_packet_unref(packet_.get());
      if (mine) TakeFrames(&sums);
      if (sums.EndsBefore(next_s_)) return sums.Means();
    }
    if (decoder_) {
      avcodec_send_packet(decoder_.get(), nullptr);
      TakeFrames(&sums);
    }
    return sums.Means();
  }

 private:
  void FindSound() {
    for (unsigned i = 0; i < format_->nb_streams; ++i) {
      AVStream* stream = format_->streams[i];
      if (!stream_ && stream->codecpar->codec_type == AVMEDIA_TYPE_AUDIO) stream_ = stream;
      if (stream != stream_) stream->discard = AVDISCARD_ALL;
    }
    const AVCodec* codec = stream_ ? avcodec_find_decoder(stream_->codecpar->codec_id) : nullptr;
    if (!codec) return;
    AvEncoder decoder(avcodec_alloc_context3(codec));
    avcodec_parameters_to_context(decoder.get(), stream_->codecpar);
    decoder->pkt_timebase = stream_->time_base;
    if (avcodec_open2(decoder.get(), codec, nullptr) >= 0) decoder_ = std::move(decoder);
  }

  void TakeFrames(MilliSums* sums) {
    while (avcodec_receive_frame(decoder_.get(), frame_.get()) >= 0) TakeFrame(*frame_, sums);
  }

  void TakeFrame(const AVFrame& frame, MilliSums* sums) {
    const Sampler sample = SamplerOf(frame);
    if (!sample || frame.sample_rate <= 0) return;
    if (frame.best_effort_timestamp != AV_NOPTS_VALUE) {
      const double time_s =
          static_cast<double>(frame.best_effort_timestamp) * av_q2d(stream_->time_base) - zero_s_;
      if (!begun_ || std::abs(time_s - next_s_) > kJump_s) next_s_ = time_s;
    }
    begun_ = true;
    const int channels = frame.ch_layout.nb_channels;
    for (int i = 0; i < frame.nb_samples; ++i) {
      double square = 0;
      for (int c = 0; c < channels; ++c) square += std::pow(sample(frame, c, i), 2);
      sums->Add(next_s_ + static_cast<double>(i) / frame.sample_rate, square / channels);
    }
    next_s_ += static_cast<double>(frame.nb_samples) / frame.sample_rate;
  }

  AvInput format_;
  AVStream* stream_ = nullptr;
  AvEncoder decoder_;
  AvPacket packet_;
  AvFrame frame_;
  double zero_s_, next_s_ = 0;
  bool begun_ = false;
};

}  // namespace

FilmSound ReadFilmSound(const std::filesystem::path& path, const FilmIndex& index, double most_s,
                        const Progress* progress) {
  return SoundReader(path, index.zero_s).Read(most_s, progress);
}

}  // namespace keypose
