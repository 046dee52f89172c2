#include "motion/video3d/depth_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace keypose::motion {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

/// A vertex in the picture.
struct Corner {
  Vector2d pixel = Vector2d::Zero();
  double inverse = 0;  ///< 1 / z; 0: not before the camera
};

/// Beyond this angle to the axis, distortion may fold the picture over.
constexpr double kWidestSlope = 3;

std::vector<Corner> Projected(const PointsX3& points, const View& view) {
  std::vector<Corner> corners(static_cast<std::size_t>(points.rows()));
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Vector3d x = view.camera_from_world * Vector3d(points.row(v));
    if (!(x.z() > 0) || x.head<2>().norm() > kWidestSlope * x.z()) continue;
    corners[v] = {view.camera.Project(x), 1 / x.z()};
  }
  return corners;
}

PixelBox BoxOf(const std::vector<Corner>& corners, const Camera& camera) {
  Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const Corner& corner : corners)
    if (corner.inverse > 0) {
      low = low.cwiseMin(corner.pixel);
      high = high.cwiseMax(corner.pixel);
    }
  // A pixel more on each side, so that the outline has pixels without surface around it.
  constexpr double kFar = 1e8;
  low = low.cwiseMax(-kFar).cwiseMin(kFar);
  high = high.cwiseMax(-kFar).cwiseMin(kFar);
  PixelBox box{static_cast<int>(std::floor(low.x())) - 1, static_cast<int>(std::floor(low.y())) - 1,
               static_cast<int>(std::ceil(high.x())) + 2,
               static_cast<int>(std::ceil(high.y())) + 2};
  box.x0 = std::max(box.x0, 0);
  box.y0 = std::max(box.y0, 0);
  box.x1 = std::min(box.x1, camera.width);
  box.y1 = std::min(box.y1, camera.height);
  return box;
}

void Draw(const std::array<Corner, 3>& t, DepthView* view) {
  const Vector2d a = t[0].pixel, b = t[1].pixel, c = t[2].pixel;
  const double twice = (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
  if (std::abs(twice) < 1e-12) return;
  const Vector2d low = a.cwiseMin(b).cwiseMin(c), high = a.cwiseMax(b).cwiseMax(c);
  const int x0 = std::max(view->box.x0, static_cast<int>(std::ceil(low.x() - 0.5))),
            x1 = std::min(view->box.x1 - 1, static_cast<int>(std::floor(high.x() - 0.5))),
            y0 = std::max(view->box.y0, static_cast<int>(std::ceil(low.y() - 0.5))),
            y1 = std::min(view->box.y1 - 1, static_cast<int>(std::floor(high.y() - 0.5)));
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const Vector2d q(x + 0.5, y + 0.5);
      const double wb = ((q - a).x() * (c - a).y() - (q - a).y() * (c - a).x()) / twice,
                   wc = ((b - a).x() * (q - a).y() - (b - a).y() * (q - a).x()) / twice;
      if (wb < -1e-9 || wc < -1e-9 || wb + wc > 1 + 1e-9) continue;
      const auto inverse =
          static_cast<float>((1 - wb - wc) * t[0].inverse + wb * t[1].inverse + wc * t[2].inverse);
      float* stored = view->inverse.at(x - view->box.x0, y - view->box.y0);
      *stored = std::max(*stored, inverse);
    }
}

}  // namespace

DepthView MakeDepthView(const PointsX3& points, const FacesX3& faces, const View& view) {
  const std::vector<Corner> corners = Projected(points, view);
  DepthView depth;
  depth.box = BoxOf(corners, view.camera);
  if (depth.box.empty()) return depth;
  depth.inverse = ImageF(depth.box.x1 - depth.box.x0, depth.box.y1 - depth.box.y0, 1, 0.0f);
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const std::array<Corner, 3> t{corners[faces(f, 0)], corners[faces(f, 1)], corners[faces(f, 2)]};
    if (t[0].inverse > 0 && t[1].inverse > 0 && t[2].inverse > 0) Draw(t, &depth);
  }
  return depth;
}

}  // namespace keypose::motion
