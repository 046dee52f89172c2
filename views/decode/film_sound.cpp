#include "views/decode/film_sound.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/values/size_of.h"
#include "views/decode/sound_file.h"
#include "views/film/late_libav.h"

namespace keypose {
namespace {

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

/// @param begin_s  of the frame's first sample
void AddFrame(const AVFrame& frame, double begin_s, MilliSums* sums) {
  const Sampler sample = SamplerOf(frame);
  if (!sample) return;
  const int channels = frame.ch_layout.nb_channels;
  for (int i = 0; i < frame.nb_samples; ++i) {
    double square = 0;
    for (int c = 0; c < channels; ++c) square += std::pow(sample(frame, c, i), 2);
    sums->Add(begin_s + static_cast<double>(i) / frame.sample_rate, square / channels);
  }
}

}  // namespace

FilmSound ReadFilmSound(const std::filesystem::path& path, const FilmIndex& index, double most_s,
                        const Progress* progress) {
  SoundFile file(path);
  MilliSums sums(most_s);
  while (const AVFrame* frame = file.Next(progress)) {
    const double begin_s = file.begin_s() - index.zero_s;
    if (sums.EndsBefore(begin_s)) break;
    AddFrame(*frame, begin_s, &sums);
  }
  return sums.Means();
}

}  // namespace keypose
