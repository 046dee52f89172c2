#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>
#include <vector>

#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_levels.h"
#include "core/numbers/parallel.h"

namespace keypose {
namespace {

template <class T>
ImageT<T> ResizedTo(const ImageT<T>& image, int width, int height) {
  constexpr double kMost = std::numeric_limits<T>::max();
  ImageT<T> out(width, height, image.channels);
  const double sx = static_cast<double>(image.width) / width,
               sy = static_cast<double>(image.height) / height;
  const double rx = std::max(1.0, sx) / 2, ry = std::max(1.0, sy) / 2;
  // Separable weights: a tent of one source pixel when enlarging, a box of the footprint when
  // shrinking.
  const auto taps = [](double center, double radius, int size) {
    std::vector<std::pair<int, double>> weights;
    double total = 0;
    const int first = static_cast<int>(std::floor(center - radius)),
              last = static_cast<int>(std::ceil(center + radius));
    for (int i = first; i <= last; ++i) {
      const double overlap =
          std::min(i + 1.0, center + radius) - std::max<double>(i, center - radius);
      if (overlap <= 0) continue;
      weights.emplace_back(std::clamp(i, 0, size - 1), overlap);
      total += overlap;
    }
    for (auto& w : weights) w.second /= total;
    return weights;
  };
  std::vector<std::vector<std::pair<int, double>>> columns(static_cast<std::size_t>(width));
  for (int x = 0; x < width; ++x) columns[x] = taps((x + 0.5) * sx, rx, image.width);
  ParallelFor(height, [&](std::int64_t row) {
    const int y = static_cast<int>(row);
    const std::vector<std::pair<int, double>> rows = taps((y + 0.5) * sy, ry, image.height);
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < image.channels; ++c) {
        double sum = 0;
        for (const auto& [j, wy] : rows)
          for (const auto& [i, wx] : columns[x]) sum += wy * wx * image.at(i, j)[c];
        out.at(x, y)[c] = static_cast<T>(std::lround(std::clamp(sum, 0.0, kMost)));
      }
  });
  return out;
}

}  // namespace

Image8 Resized(const Image8& image, int width, int height) {
  return ResizedTo(image, width, height);
}

Image16 Resized(const Image16& image, int width, int height) {
  return ResizedTo(image, width, height);
}

Image8 ResizedMask(const Image8& mask, int width, int height) {
  Image8 resized = Resized(mask, width, height);
  for (std::uint8_t& pixel : resized.data) pixel = pixel > 127 ? 255 : 0;
  return resized;
}

}  // namespace keypose
