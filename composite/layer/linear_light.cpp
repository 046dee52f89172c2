#include "composite/layer/linear_light.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"

namespace keypose::composite {
namespace {

template <class Change>
void ForAll(std::size_t count, const Change& change) {
  ParallelBlocks(static_cast<std::int64_t>(count), 1 << 16,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) change(i);
                 });
}

/// One direction of the blur, for rows or columns.
ImageF BlurredAlong(const ImageF& image, const std::vector<float>& kernel, bool rows) {
  const int radius = static_cast<int>(kernel.size() / 2), channels = image.channels;
  ImageF out(image.width, image.height, channels);
  ParallelFor(image.height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < image.width; ++x)
      for (int k = -radius; k <= radius; ++k) {
        const int px = rows ? std::clamp(x + k, 0, image.width - 1) : x,
                  py = rows ? y : std::clamp(y + k, 0, image.height - 1);
        const float* in = image.at(px, py);
        float* to = out.at(x, y);
        for (int c = 0; c < channels; ++c) to[c] += kernel[k + radius] * in[c];
      }
  });
  return out;
}

}  // namespace

ImageF LinearOf(const Image8& srgb) {
  ImageF linear(srgb.width, srgb.height, srgb.channels);
  ForAll(srgb.data.size(), [&](std::int64_t i) { linear.data[i] = kLinear[srgb.data[i]]; });
  return linear;
}

ImageF LinearOfLevels(const ImageF& levels) {
  ImageF linear(levels.width, levels.height, levels.channels);
  ForAll(levels.data.size(), [&](std::int64_t i) {
    const double level = std::clamp(static_cast<double>(levels.data[i]), 0.0, 255.0);
    const auto whole = static_cast<std::size_t>(level);
    linear.data[i] = static_cast<double>(whole) == level
                         ? kLinear[whole]
                         : static_cast<float>(LinearFromSrgb(level / 255));
  });
  return linear;
}

ImageF LevelsOf(const ImageF& linear) {
  ImageF levels(linear.width, linear.height, linear.channels);
  ForAll(linear.data.size(), [&](std::int64_t i) {
    const double light = std::clamp(static_cast<double>(linear.data[i]), 0.0, 1.0);
    levels.data[i] = static_cast<float>(255 * SrgbFromLinear(light));
  });
  return levels;
}

Image8 SrgbOf(const ImageF& linear) { return Rounded(LevelsOf(linear)); }

Image8 Rounded(const ImageF& levels) {
  Image8 rounded(levels.width, levels.height, levels.channels);
  ForAll(levels.data.size(), [&](std::int64_t i) {
    rounded.data[i] =
        static_cast<std::uint8_t>(std::lround(std::clamp(levels.data[i], 0.0f, 255.0f)));
  });
  return rounded;
}

ImageF Blurred(const ImageF& image, double sigma_px) {
  if (sigma_px <= 0) return image;
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma_px)));
  std::vector<float> kernel(static_cast<std::size_t>(2 * radius + 1));
  float sum = 0;
  for (int k = -radius; k <= radius; ++k)
    sum += kernel[k + radius] = static_cast<float>(std::exp(-0.5 * k * k / (sigma_px * sigma_px)));
  for (float& weight : kernel) weight /= sum;
  return BlurredAlong(BlurredAlong(image, kernel, true), kernel, false);
}

}  // namespace keypose::composite
