// The sound of a film, as samples.
#pragma once

#include <cstdint>
#include <vector>

namespace keypose {

/// Samples a second of each channel of a Sound.
inline constexpr int kSoundRate = 48000;

/// Sound of two channels.
struct Sound {
  std::vector<float> samples;  ///< left and right in turn, in [-1, 1]

  /// Of one channel.
  std::int64_t length() const { return static_cast<std::int64_t>(samples.size() / 2); }
  double seconds() const { return static_cast<double>(length()) / kSoundRate; }
};

/// The sound `at_s` later: silence before it. A negative time leaves out its begin.
Sound Moved(const Sound& sound, double at_s);

}  // namespace keypose
