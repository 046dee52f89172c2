#include "views/decode/read_sound.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/values/errors.h"
#include "views/decode/film_index.h"
#include "views/decode/sound_file.h"
#include "views/film/late_libav.h"

namespace keypose {
namespace {

/// A damaged beginning or end is usual where a sound was cut out of a stream.
constexpr int kMostDamagedParts = 2;

/// Turns frames of any kind into a Sound, each at its time.
class SoundSamples {
 public:
  /// @param name  of the file, for messages
  explicit SoundSamples(std::string name) : name_(std::move(name)) {}
  SoundSamples(const SoundSamples&) = delete;
  SoundSamples& operator=(const SoundSamples&) = delete;
  ~SoundSamples() { swr_free(&converter_); }

  /// @param begin_s  of its first sample, from the sound's begin on
  void Add(const AVFrame& frame, double begin_s) {
    if (!IsOf(frame) || begin_s > end_s_ + kTolerance_s) {
      Flush();
      Configure(frame);
      if (sound_.samples.empty()) origin_s_ = std::min(begin_s, 0.0);
      Reach(begin_s - origin_s_);
    }
    Convert(const_cast<const std::uint8_t**>(frame.extended_data), frame.nb_samples);
    end_s_ = begin_s + static_cast<double>(frame.nb_samples) / frame.sample_rate;
  }
  Sound Finished() {
    Flush();
    return Moved(sound_, origin_s_);
  }
  double seconds() const { return sound_.seconds(); }

 private:
  static constexpr double kTolerance_s = 1e-4;

  bool IsOf(const AVFrame& frame) const {
    return converter_ && frame.format == format_ && frame.sample_rate == rate_ &&
           frame.ch_layout.nb_channels == channels_;
  }
  void Configure(const AVFrame& frame) {
    format_ = frame.format, rate_ = frame.sample_rate, channels_ = frame.ch_layout.nb_channels;
    AVChannelLayout from{}, to{};
    if (frame.ch_layout.order == AV_CHANNEL_ORDER_UNSPEC)
      av_channel_layout_default(&from, channels_);
    else
      av_channel_layout_copy(&from, &frame.ch_layout);
    av_channel_layout_default(&to, 2);
    swr_free(&converter_);
    int code = swr_alloc_set_opts2(&converter_, &to, AV_SAMPLE_FMT_FLT, kSoundRate, &from,
                                   static_cast<AVSampleFormat>(format_), rate_, 0, nullptr);
    constexpr double kBoth[] = {1, 1};  // else one channel would be 3 dB quieter on both sides
    if (code >= 0 && channels_ == 1) code = swr_set_matrix(converter_, kBoth, 1);
    if (code >= 0) code = swr_init(converter_);
    av_channel_layout_uninit(&from);
    if (code < 0)
      throw InputError(
          fmt::format("{} has {} channels that cannot be mixed down to two; save it as stereo",
                      name_, channels_));
  }
  /// Silence up to this time; of what overlaps, the first stays.
  void Reach(double seconds) {
    const std::size_t wanted = 2 * static_cast<std::size_t>(std::llround(
                                       std::clamp(seconds, 0.0, 2 * kLongestSound_s) * kSoundRate));
    if (wanted > sound_.samples.size()) sound_.samples.resize(wanted);
  }
  void Convert(const std::uint8_t** data, int count) {
    const int room = swr_get_out_samples(converter_, count);
    if (room <= 0) return;
    const std::size_t before = sound_.samples.size();
    sound_.samples.resize(before + 2 * static_cast<std::size_t>(room));
    auto* out = reinterpret_cast<std::uint8_t*>(sound_.samples.data() + before);
    const int made = std::max(0, swr_convert(converter_, &out, room, data, count));
    sound_.samples.resize(before + 2 * static_cast<std::size_t>(made));
  }
  void Flush() {
    if (converter_) Convert(nullptr, 0);
  }

  std::string name_;
  Sound sound_;
  SwrContext* converter_ = nullptr;
  int format_ = -1, rate_ = 0, channels_ = 0;
  double origin_s_ = 0;  // of the first sample; what is before 0 is left out
  double end_s_ = 0;
};

}  // namespace

Sound ReadSound(const std::filesystem::path& path, const Progress* progress) {
  if (!std::filesystem::exists(path))
    throw DiskError(fmt::format("there is no sound {}", path.string()));
  SoundFile file(path);
  if (!file.fault().empty())
    throw InputError(
        fmt::format("{} {}; a sound is WAV, FLAC, MP3, Opus or another that ffmpeg decodes",
                    path.string(), file.fault()));
  SoundSamples samples("the sound " + path.string());
  double zero_s = file.is_film() ? ReadFilmIndex(path).zero_s : 0;
  bool first = true;
  while (const AVFrame* frame = file.Next(progress)) {
    if (first && !file.is_film()) zero_s = file.begin_s();
    first = false;
    samples.Add(*frame, file.begin_s() - zero_s);
    if (samples.seconds() > kLongestSound_s)
      throw InputError(
          fmt::format("the sound {} is longer than {:.0f} minutes; cut out what the "
                      "animation needs",
                      path.string(), kLongestSound_s / 60));
  }
  if (first || file.faults() > kMostDamagedParts)
    throw InputError(
        fmt::format("the sound {} is damaged: {}", path.string(),
                    first ? "nothing of it can be decoded"
                          : fmt::format("{} parts of it cannot be decoded", file.faults())));
  Sound sound = samples.Finished();
  if (!std::all_of(sound.samples.begin(), sound.samples.end(),
                   [](float sample) { return std::isfinite(sample); }))
    throw InputError(fmt::format(
        "the sound {} holds samples that are no numbers (NaN or infinite); save it anew as 24 bits",
        path.string()));
  return sound;
}

HeardSound ReadSoundAt(const std::filesystem::path& path, double at_s, double film_s,
                       const Progress* progress) {
  const Sound whole = ReadSound(path, progress);
  HeardSound heard{Moved(whole, at_s), ""};
  if (at_s < film_s && heard.sound.length() > 0) return heard;
  heard.warning = fmt::format(
      "nothing of the sound is heard: it lasts {:.2f} s and begins at {:.2f} s of a film of {:.2f} "
      "s; "
      "give another sound_at",
      whole.seconds(), at_s, film_s);
  return heard;
}

}  // namespace keypose
