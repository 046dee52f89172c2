#include "views/hull/depth_bounds.h"

#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"

namespace keypose {
namespace {

constexpr double kMarginVoxels = 1.5;

struct Entries {
  ImageF nearest, farthest;  // inverse depths, 0: none
};

Entries MarchAll(const VisualHull& hull, const PreparedView& view, int level) {
  const Pinhole& camera = view.camera(level);
  const GreyMask& grey = view.levels[level].grey;
  Entries out{ImageF(camera.width, camera.height, 1), ImageF(camera.width, camera.height, 1)};
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d center = view.Center();
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      // The mask's border is known to half a pixel of the coarse level, so neighbours count too.
      bool near_mask = false;
      for (int k = 0; k < 9 && !near_mask; ++k) {
        const int nx = std::clamp(x + k % 3 - 1, 0, camera.width - 1),
                  ny = std::clamp(y + k / 3 - 1, 0, camera.height - 1);
        near_mask = InMask(*grey.at(nx, ny));
      }
      if (!near_mask) continue;
      const Eigen::Vector3d ray = camera.Ray(x, y);  // z = 1, so distances along it are depths
      const auto interval = hull.March(center, world_from_camera * ray);
      if (!interval) continue;
      const double margin = kMarginVoxels * hull.cell / ray.norm();
      const double front = std::max(interval->front - margin, 0.05 * interval->front);
      *out.nearest.at(x, y) = static_cast<float>(1 / front);
      *out.farthest.at(x, y) = static_cast<float>(1 / (interval->back + margin));
    }
  return out;
}

// Least-squares plane through those entries of a 7 x 7 window that belong to the same surface.
Eigen::Vector2f Slope(const ImageF& nearest, int x, int y, float largest_jump) {
  const float center = *nearest.at(x, y);
  Eigen::Matrix2f a = Eigen::Matrix2f::Zero();
  Eigen::Vector2f b = Eigen::Vector2f::Zero();
  for (int dy = -3; dy <= 3; ++dy)
    for (int dx = -3; dx <= 3; ++dx) {
      const int nx = x + dx, ny = y + dy;
      if (nx < 0 || ny < 0 || nx >= nearest.width || ny >= nearest.height) continue;
      const float w = *nearest.at(nx, ny);
      if (w <= 0 || std::abs(w - center) > largest_jump) continue;
      const Eigen::Vector2f d(static_cast<float>(dx), static_cast<float>(dy));
      a += d * d.transpose();
      b += d * (w - center);
    }
  // Sums of whole numbers, so the determinant is one too: it is 0 where all entries lie on one line
  // through the centre, which says the slope along this line only.
  if (a.determinant() < 0.5f) return b / std::max(a.trace(), 1.0f);
  return a.inverse() * b;
}

}  // namespace

DepthBounds HullDepthBounds(const VisualHull& hull, const PreparedView& view) {
  const int level = SizeOf(view.levels) - 1;
  const Entries entries = MarchAll(hull, view, level);
  const int width = entries.nearest.width, height = entries.nearest.height;
  DepthBounds bounds{level, ImageF(width, height, 1), ImageF(width, height, 1),
                     ImageF(width, height, 2)};
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float nearest = 0, farthest = 0;
      for (int k = 0; k < 9; ++k) {
        const int nx = std::clamp(x + k % 3 - 1, 0, width - 1),
                  ny = std::clamp(y + k / 3 - 1, 0, height - 1);
        const float w = *entries.nearest.at(nx, ny), v = *entries.farthest.at(nx, ny);
        if (w <= 0) continue;
        nearest = std::max(nearest, w);
        farthest = farthest > 0 ? std::min(farthest, v) : v;
      }
      *bounds.nearest.at(x, y) = nearest;
      *bounds.farthest.at(x, y) = farthest;
      const float entry = *entries.nearest.at(x, y);
      if (entry <= 0) continue;
      const float jump = static_cast<float>(10 * hull.cell) * entry * entry;
      const Eigen::Vector2f slope = Slope(entries.nearest, x, y, jump);
      bounds.slope.at(x, y)[0] = slope.x();
      bounds.slope.at(x, y)[1] = slope.y();
    }
  return bounds;
}

}  // namespace keypose
