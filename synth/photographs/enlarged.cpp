#include "synth/photographs/enlarged.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "core/numbers/parallel.h"

namespace keypose::synth {
namespace {

/// Weights of the four pixels around a place, and the first of them.
struct Taps {
  int first = 0;
  std::array<float, 4> weights{};
};

std::vector<Taps> TapsOf(int size, int factor) {
  std::vector<Taps> taps(static_cast<std::size_t>(size) * factor);
  for (std::size_t i = 0; i < taps.size(); ++i) {
    const double at = (static_cast<double>(i) + 0.5) / factor - 0.5, t = at - std::floor(at);
    taps[i].first = static_cast<int>(std::floor(at)) - 1;
    taps[i].weights = {static_cast<float>(0.5 * t * (t * (2 - t) - 1)),
                       static_cast<float>(0.5 * (t * t * (3 * t - 5) + 2)),
                       static_cast<float>(0.5 * t * (t * (4 - 3 * t) + 1)),
                       static_cast<float>(0.5 * t * t * (t - 1))};
  }
  return taps;
}

}  // namespace

ImageF Enlarged(ImageF image, int factor) {
  if (factor == 1) return image;
  const int channels = image.channels;
  const std::vector<Taps> across = TapsOf(image.width, factor), down = TapsOf(image.height, factor);
  ImageF wide(image.width * factor, image.height, channels);
  ParallelFor(
      image.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < wide.width; ++x)
          for (int k = 0; k < 4; ++k) {
            const float* in = image.at(std::clamp(across[x].first + k, 0, image.width - 1), y);
            for (int c = 0; c < channels; ++c) wide.at(x, y)[c] += across[x].weights[k] * in[c];
          }
      },
      16);
  ImageF large(wide.width, image.height * factor, channels);
  ParallelFor(
      large.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        float* out = large.at(0, y);
        const std::int64_t values = static_cast<std::int64_t>(large.width) * channels;
        for (int k = 0; k < 4; ++k) {
          const float* in = wide.at(0, std::clamp(down[y].first + k, 0, image.height - 1));
          for (std::int64_t i = 0; i < values; ++i) out[i] += down[y].weights[k] * in[i];
        }
        for (std::int64_t i = 0; i < values; ++i) out[i] = std::max(0.0f, out[i]);
      },
      16);
  return large;
}

}  // namespace keypose::synth
