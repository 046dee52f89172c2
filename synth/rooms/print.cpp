#include "synth/rooms/print.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/size_of.h"

namespace keypose::synth {
namespace {

using Eigen::Vector3d;

/// sRGB bytes of linear light in 1/4095.
const std::array<std::uint8_t, 4096>& ByteOfLinear() {
  static const std::array<std::uint8_t, 4096> table = [] {
    std::array<std::uint8_t, 4096> values{};
    for (int i = 0; i < 4096; ++i)
      values[i] = static_cast<std::uint8_t>(std::lround(255 * SrgbFromLinear(i / 4095.0)));
    return values;
  }();
  return table;
}

/// Half the size; light is averaged, not bytes.
Image8 Halved(const Image8& image) {
  const auto& bytes = ByteOfLinear();
  Image8 half(std::max(1, image.width / 2), std::max(1, image.height / 2), 3);
  ParallelFor(
      half.height,
      [&](std::int64_t row) {
        const int y = static_cast<int>(row);
        for (int x = 0; x < half.width; ++x) {
          const int x0 = 2 * x, x1 = std::min(x0 + 1, image.width - 1), y0 = 2 * y,
                    y1 = std::min(y0 + 1, image.height - 1);
          for (int c = 0; c < 3; ++c) {
            const float sum = kLinear[image.at(x0, y0)[c]] + kLinear[image.at(x1, y0)[c]] +
                              kLinear[image.at(x0, y1)[c]] + kLinear[image.at(x1, y1)[c]];
            half.at(x, y)[c] = bytes[static_cast<int>(sum / 4 * 4095 + 0.5f)];
          }
        }
      },
      16);
  return half;
}

int Wrapped(int i, int n, bool repeats) {
  if (!repeats) return std::clamp(i, 0, n - 1);
  const int rest = i % n;
  return rest < 0 ? rest + n : rest;
}

}  // namespace

Print::Print(Image8 picture, double width_m, bool repeats)
    : width_m_(width_m),
      height_m_(width_m * picture.height / picture.width),
      texel_m_(width_m / picture.width),
      repeats_(repeats) {
  levels_.push_back(std::move(picture));
  while (levels_.back().width > 1 && levels_.back().height > 1)
    levels_.push_back(Halved(levels_.back()));
}

Vector3d Print::AtLevel(const Image8& level, double x, double y) const {
  const double px = x / width_m_ * level.width - 0.5, py = y / height_m_ * level.height - 0.5;
  const double fx = std::floor(px), fy = std::floor(py);
  const int x0 = Wrapped(static_cast<int>(fx), level.width, repeats_),
            x1 = Wrapped(static_cast<int>(fx) + 1, level.width, repeats_),
            y0 = Wrapped(static_cast<int>(fy), level.height, repeats_),
            y1 = Wrapped(static_cast<int>(fy) + 1, level.height, repeats_);
  const double u = px - fx, v = py - fy;
  const std::uint8_t *a = level.at(x0, y0), *b = level.at(x1, y0), *c = level.at(x0, y1),
                     *d = level.at(x1, y1);
  Vector3d sum;
  for (int k = 0; k < 3; ++k)
    sum[k] = (1 - v) * ((1 - u) * kLinear[a[k]] + u * kLinear[b[k]]) +
             v * ((1 - u) * kLinear[c[k]] + u * kLinear[d[k]]);
  return sum;
}

Vector3d Print::At(double x, double y, double footprint_m) const {
  const double level =
      std::clamp(std::log2(std::max(footprint_m / texel_m_, 1e-6)), 0.0, SizeOf(levels_) - 1.0);
  const int below = static_cast<int>(level), above = std::min(below + 1, SizeOf(levels_) - 1);
  const double share = level - below;
  const Vector3d fine = AtLevel(levels_[below], x, y);
  if (share == 0) return fine;
  return (1 - share) * fine + share * AtLevel(levels_[above], x, y);
}

}  // namespace keypose::synth
