// From light to a photograph: lens blur, vignetting, sensor noise, sRGB.
#pragma once

#include <cstdint>

#include "core/values/image.h"

namespace keypose::synth {

struct SensorOptions {
  double blur_px = 0.5;     ///< standard deviation; 0: none
  double vignetting = 0.1;  ///< share of light lost in the corners, in [0,1)
  double noise = 1;         ///< 1: an ordinary camera at ISO 200
  std::uint64_t seed = 1;   ///< of the noise; different for every photograph
};

/// Develops linear RGB (1 = white) into an 8-bit sRGB photograph.
Image8 Develop(ImageF linear, const SensorOptions& options);

}  // namespace keypose::synth
