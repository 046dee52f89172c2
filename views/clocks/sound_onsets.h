// A sound as a signal that clocks are compared by: where it sets in.
#pragma once

#include <vector>

#include "views/clocks/signal_offset.h"

namespace keypose {

/// Sound as its power in each millisecond.
struct SoundPower {
  double first_s = 0;            ///< begin of the first millisecond, by the film's clock
  std::vector<float> per_milli;  ///< mean square of samples in [-1, 1]
};

/// How much louder each millisecond is than the ten before it, in natural logarithms; less than the
/// film's usual noise counts for nothing. Recording levels and echoes matter little to it.
/// @return empty for silence
Signal SoundOnsets(const SoundPower& power);

}  // namespace keypose
