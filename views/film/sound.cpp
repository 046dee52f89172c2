#include "views/film/sound.h"

#include <algorithm>
#include <cmath>

namespace keypose {

Sound Moved(const Sound& sound, double at_s) {
  const std::int64_t by = std::llround(at_s * kSoundRate);
  Sound moved;
  moved.samples.assign(static_cast<std::size_t>(2 * std::max<std::int64_t>(by, 0)), 0.f);
  const std::int64_t first = std::min(std::max<std::int64_t>(-by, 0), sound.length());
  moved.samples.insert(moved.samples.end(), sound.samples.begin() + 2 * first, sound.samples.end());
  return moved;
}

}  // namespace keypose
