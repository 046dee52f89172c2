#include "reconstruct/turntable/mask_outline.h"

#include <algorithm>
#include <cmath>

namespace keypose::reconstruct {
namespace {

bool IsInside(const Image8& mask, int x, int y) { return *mask.at(x, y) > 127; }

/// Distance of each pixel's centre to the outline, by two sweeps with steps of 1 and sqrt 2;
/// positive outside.
ImageF SignedDistance(const Image8& mask) {
  ImageF distance(mask.width, mask.height, 1, 1e6F);
  const auto relax = [&](int x, int y, int dx, int dy, float step) {
    const int nx = x + dx, ny = y + dy;
    if (nx < 0 || ny < 0 || nx >= mask.width || ny >= mask.height) return;
    const float through =
        IsInside(mask, x, y) != IsInside(mask, nx, ny) ? 0.5F * step : *distance.at(nx, ny) + step;
    *distance.at(x, y) = std::min(*distance.at(x, y), through);
  };
  const float diagonal = std::sqrt(2.0F);
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      relax(x, y, -1, 0, 1);
      relax(x, y, 0, -1, 1);
      relax(x, y, -1, -1, diagonal);
      relax(x, y, 1, -1, diagonal);
    }
  for (int y = mask.height - 1; y >= 0; --y)
    for (int x = mask.width - 1; x >= 0; --x) {
      relax(x, y, 1, 0, 1);
      relax(x, y, 0, 1, 1);
      relax(x, y, 1, 1, diagonal);
      relax(x, y, -1, 1, diagonal);
    }
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x)
      if (IsInside(mask, x, y)) *distance.at(x, y) = -*distance.at(x, y);
  return distance;
}

ImageF Shrunk(const ImageF& distance, int factor) {
  ImageF small(std::max(1, distance.width / factor), std::max(1, distance.height / factor), 1);
  for (int y = 0; y < small.height; ++y)
    for (int x = 0; x < small.width; ++x) {
      float sum = 0;
      for (int dy = 0; dy < factor; ++dy)
        for (int dx = 0; dx < factor; ++dx)
          sum += *distance.at(std::min(distance.width - 1, x * factor + dx),
                              std::min(distance.height - 1, y * factor + dy));
      *small.at(x, y) = sum / static_cast<float>(factor * factor * factor);
    }
  return small;
}

}  // namespace

MaskOutline MakeOutline(const Image8& mask, const Camera& camera, int factor) {
  MaskOutline outline;
  const ImageF distance = SignedDistance(mask);
  outline.distance = Shrunk(distance, factor);
  double sum_x = 0, sum_y = 0, count = 0;
  std::vector<Eigen::Vector2d> rim;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      if (!IsInside(mask, x, y)) continue;
      sum_x += x + 0.5;
      sum_y += y + 0.5;
      count += 1;
      const bool within = x > 1 && y > 1 && x + 2 < mask.width && y + 2 < mask.height;
      if (within && *distance.at(x, y) > -0.75F) rim.emplace_back(x + 0.5, y + 0.5);
    }
  if (count == 0) return outline;
  const Eigen::Vector2d middle(sum_x / count, sum_y / count);
  outline.middle = camera.Unproject(middle);
  outline.area = count / (camera.fx * camera.fy);
  std::stable_sort(rim.begin(), rim.end(), [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return std::atan2(a.y() - middle.y(), a.x() - middle.x()) <
           std::atan2(b.y() - middle.y(), b.x() - middle.x());
  });
  constexpr std::size_t kMost = 360;
  for (std::size_t k = 0; k < std::min(kMost, rim.size()); ++k)
    outline.rays.push_back(camera.Unproject(rim[k * rim.size() / std::min(kMost, rim.size())]));
  return outline;
}

}  // namespace keypose::reconstruct
