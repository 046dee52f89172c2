#include "core/pictures/image_quality.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/numbers/parallel.h"

namespace keypose {
namespace {

constexpr int kRadius = 5;
constexpr double kSigma = 1.5;

using Plane = std::vector<double>;

std::array<double, 2 * kRadius + 1> Window() {
  std::array<double, 2 * kRadius + 1> window;
  for (int i = -kRadius; i <= kRadius; ++i)
    window[i + kRadius] = std::exp(-0.5 * i * i / (kSigma * kSigma));
  return window;
}

/// Separable weighted sums. Pixels beyond the border count as 0.
Plane Blurred(const Plane& plane, int width, int height) {
  const auto window = Window();
  Plane rows(plane.size()), result(plane.size());
  ParallelFor(height, [&](std::int64_t y) {
    const double* from = plane.data() + y * width;
    double* to = rows.data() + y * width;
    for (int i = -kRadius; i <= kRadius; ++i) {
      const double weight = window[i + kRadius];
      for (int x = std::max(0, -i); x < std::min(width, width - i); ++x)
        to[x] += weight * from[x + i];
    }
  });
  ParallelFor(height, [&](std::int64_t y) {
    const int row = static_cast<int>(y);
    for (int i = std::max(-kRadius, -row); i <= std::min(kRadius, height - 1 - row); ++i)
      for (int x = 0; x < width; ++x)
        result[y * width + x] += window[i + kRadius] * rows[(y + i) * width + x];
  });
  return result;
}

/// The bounding box of the valid pixels; x1, y1 are one beyond the last.
struct Box {
  int x0, y0, x1, y1;
  bool empty() const { return x1 <= x0; }
};

Box ValidBox(const std::vector<char>& valid, int width, int height) {
  Box box{width, height, 0, 0};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      if (valid[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                static_cast<std::size_t>(x)])
        box = {std::min(box.x0, x), std::min(box.y0, y), std::max(box.x1, x + 1),
               std::max(box.y1, y + 1)};
  return box;
}

/// The sums for the index, weighted by window and validity: 1, a, b, aa, bb, ab.
std::array<Plane, 6> WindowSums(const ImageT<double>& a, const ImageT<double>& b,
                                const std::vector<char>& valid, const Box& box) {
  const int width = box.x1 - box.x0, height = box.y1 - box.y0;
  std::array<Plane, 6> sums;
  for (Plane& plane : sums)
    plane.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const std::size_t i =
          static_cast<std::size_t>(box.y0 + y) * static_cast<std::size_t>(a.width) +
          static_cast<std::size_t>(box.x0 + x);
      if (!valid[i]) continue;
      const double la = a.data[i], lb = b.data[i];
      const double values[6] = {1, la, lb, la * la, lb * lb, la * lb};
      for (std::size_t k = 0; k < 6; ++k) sums[k][y * width + x] = values[k];
    }
  for (Plane& plane : sums) plane = Blurred(plane, width, height);
  return sums;
}

double SimilarityAt(const std::array<Plane, 6>& sums, std::size_t i) {
  constexpr double kC1 = 0.01 * 255 * 0.01 * 255, kC2 = 0.03 * 255 * 0.03 * 255;
  const double n = sums[0][i], ma = sums[1][i] / n, mb = sums[2][i] / n;
  const double aa = sums[3][i] / n - ma * ma, bb = sums[4][i] / n - mb * mb,
               ab = sums[5][i] / n - ma * mb;
  return (2 * ma * mb + kC1) * (2 * ab + kC2) / ((ma * ma + mb * mb + kC1) * (aa + bb + kC2));
}

}  // namespace

double Psnr(double sum_of_squares, double count) {
  if (count <= 0) return 0;
  const double mean = sum_of_squares / count;
  return mean > 0 ? std::min(99.0, 10 * std::log10(255.0 * 255.0 / mean)) : 99.0;
}

double Ssim(const ImageT<double>& a, const ImageT<double>& b, const std::vector<char>& valid) {
  const Box box = ValidBox(valid, a.width, a.height);
  if (box.empty()) return 1;
  const std::array<Plane, 6> sums = WindowSums(a, b, valid, box);
  double total = 0;
  long count = 0;
  for (int y = box.y0; y < box.y1; ++y)
    for (int x = box.x0; x < box.x1; ++x) {
      if (!valid[static_cast<std::size_t>(y) * static_cast<std::size_t>(a.width) +
                 static_cast<std::size_t>(x)])
        continue;
      total += SimilarityAt(
          sums, static_cast<std::size_t>((y - box.y0) * (box.x1 - box.x0) + x - box.x0));
      ++count;
    }
  return total / static_cast<double>(count);
}

}  // namespace keypose
