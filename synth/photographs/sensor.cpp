#include "synth/photographs/sensor.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/pictures/srgb.h"
#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

// Rows, then columns, with the border repeated.
void Blur(ImageF& image, double sigma) {
  const int radius = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
  std::vector<float> kernel(2 * radius + 1);
  float sum = 0;
  for (int i = -radius; i <= radius; ++i)
    sum += kernel[i + radius] = static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma)));
  for (float& k : kernel) k /= sum;
  const int channels = image.channels;
  const auto pass = [&](int count, int lines, std::size_t step, std::size_t line_step) {
    std::vector<float> line(static_cast<std::size_t>(count + 2 * radius) * channels);
    for (int l = 0; l < lines; ++l) {
      float* start = image.data.data() + line_step * l;
      for (int i = -radius; i < count + radius; ++i)
        std::copy_n(start + step * std::clamp(i, 0, count - 1), channels,
                    line.data() + static_cast<std::size_t>(i + radius) * channels);
      for (int i = 0; i < count; ++i)
        for (int c = 0; c < channels; ++c) {
          float value = 0;
          for (int k = 0; k <= 2 * radius; ++k)
            value += kernel[k] * line[static_cast<std::size_t>(i + k) * channels + c];
          start[step * i + c] = value;
        }
    }
  };
  const std::size_t row = static_cast<std::size_t>(image.width) * channels;
  pass(image.width, image.height, channels, row);
  pass(image.height, image.width, row, channels);
}

// Linear light in 1/65535 to an sRGB byte.
const std::vector<std::uint8_t>& SrgbTable() {
  static const std::vector<std::uint8_t> table = [] {
    std::vector<std::uint8_t> t(65536);
    for (int i = 0; i < 65536; ++i) {
      t[i] = static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(i / 65535.0)));
    }
    return t;
  }();
  return table;
}

// Approximately normal: the sum of four uniform numbers from one hash. The tails end at 3.5 sigma,
// like a sensor's.
float NoiseAt(std::uint64_t key) {
  const std::uint64_t h = Hash(key);
  const double sum =
      static_cast<double>((h & 0xffff) + (h >> 16 & 0xffff) + (h >> 32 & 0xffff) + (h >> 48)) /
      65535.0;
  return static_cast<float>((sum - 2) * 1.7320508075688772);
}

}  // namespace

Image8 Develop(ImageF linear, const SensorOptions& options) {
  if (options.blur_px > 0) Blur(linear, options.blur_px);
  Image8 photograph(linear.width, linear.height, 3);
  const std::vector<std::uint8_t>& srgb = SrgbTable();
  const double cx = linear.width / 2.0, cy = linear.height / 2.0, corner2 = cx * cx + cy * cy;
  const std::uint64_t stream = Hash(options.seed) << 20;
  for (int y = 0; y < linear.height; ++y)
    for (int x = 0; x < linear.width; ++x) {
      const double r2 =
          ((x + 0.5 - cx) * (x + 0.5 - cx) + (y + 0.5 - cy) * (y + 0.5 - cy)) / corner2;
      const float gain = static_cast<float>(1 - options.vignetting * r2);
      const float* in = linear.at(x, y);
      std::uint8_t* out = photograph.at(x, y);
      const std::uint64_t pixel = static_cast<std::uint64_t>(y) * linear.width + x;
      for (int c = 0; c < 3; ++c) {
        const float light = std::max(0.0f, in[c] * gain);
        // Shot noise grows with the light; read noise does not.
        const float sigma = static_cast<float>(options.noise) * std::sqrt(1.2e-4f * light + 4e-6f);
        const float value =
            light + sigma * (options.noise > 0 ? NoiseAt(stream + 3 * pixel + c) : 0.0f);
        out[c] = srgb[static_cast<int>(std::clamp(value, 0.0f, 1.0f) * 65535.0f + 0.5f)];
      }
    }
  return photograph;
}

}  // namespace keypose::synth
