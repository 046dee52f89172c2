#include "reconstruct/hull_fill.h"

#include <algorithm>
#include <cmath>
#include <memory>

#include "core/kd_tree.h"
#include "core/parallel.h"

namespace keypose::reconstruct {
namespace {

constexpr double kStereoVoxels = 3;
constexpr double kConfirmedShare = 0.1;

// What the views that look at a place of the hull say of it.
struct Witness {
  int views = 0;
  int pixels = 0, confirmed = 0;
  Eigen::Vector3d color_sum = Eigen::Vector3d::Zero();
};

void Ask(const DenseView& view, const DepthBounds& bounds, const std::vector<char>& confirmed, const Eigen::Vector3d& point,
         const Eigen::Vector3d& normal, double cell, Witness* witness) {
  const Eigen::Vector3d x = view.camera_from_world * point;
  if (x.z() <= 0 || (view.Center() - point).normalized().dot(normal) < 0.2) return;
  const Pinhole& camera = view.camera();
  const Eigen::Vector2d p = camera.Project(x);
  const int px = static_cast<int>(std::lround(p.x())), py = static_cast<int>(std::lround(p.y()));
  if (px < 0 || py < 0 || px >= camera.width || py >= camera.height || !InMask(*view.levels[0].grey.at(px, py))) return;
  // Hidden by another part of the hull? The bounds carry a margin and a window's maximum.
  const int bx = std::min(px >> bounds.shift, bounds.nearest.width - 1), by = std::min(py >> bounds.shift, bounds.nearest.height - 1);
  const double nearest = *bounds.nearest.at(bx, by);
  if (nearest <= 0 || x.z() - 1 / nearest > 6 * cell) return;
  const int radius = std::clamp(static_cast<int>(std::lround(camera.fx * cell / x.z())), 1, 8);
  for (int y = std::max(0, py - radius); y <= std::min(camera.height - 1, py + radius); ++y)
    for (int xx = std::max(0, px - radius); xx <= std::min(camera.width - 1, px + radius); ++xx) {
      ++witness->pixels;
      witness->confirmed += !confirmed.empty() && confirmed[static_cast<std::size_t>(y) * camera.width + xx];
    }
  const std::uint8_t* rgb = view.color.at(px, py);
  witness->color_sum += Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
  ++witness->views;
}

}  // namespace

PointCloud HullFill(const VisualHull& hull, const std::vector<DenseView>& views, const std::vector<DepthBounds>& bounds,
                    const std::vector<std::vector<char>>& confirmed, const PointsX3& stereo_points) {
  const PointCloud surface = HullSurface(hull);
  const std::unique_ptr<KdTree> tree = stereo_points.rows() ? std::make_unique<KdTree>(stereo_points) : nullptr;
  const double reach = kStereoVoxels * hull.cell;
  std::vector<Witness> witnesses(surface.points.rows());
  ParallelFor(
      surface.points.rows(),
      [&](std::int64_t i) {
        const Eigen::Vector3d point = surface.points.row(i), normal = surface.normals.row(i);
        if (tree && tree->Nearest(point).squared_distance < reach * reach) return;
        for (std::size_t v = 0; v < views.size(); ++v) Ask(views[v], bounds[v], confirmed[v], point, normal, hull.cell, &witnesses[i]);
      },
      64);
  std::vector<int> kept;
  for (int i = 0; i < surface.points.rows(); ++i)
    if (witnesses[i].views >= 2 && witnesses[i].confirmed <= kConfirmedShare * witnesses[i].pixels) kept.push_back(i);
  PointCloud out;
  out.points = surface.points(kept, Eigen::all);
  out.normals = surface.normals(kept, Eigen::all);
  out.colors.resize(static_cast<int>(kept.size()), 3);
  out.confidence = Eigen::VectorXf::Constant(static_cast<int>(kept.size()), kHullConfidence);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const Eigen::Vector3d color = witnesses[kept[k]].color_sum / witnesses[kept[k]].views;
    for (int c = 0; c < 3; ++c) out.colors(static_cast<int>(k), c) = static_cast<std::uint8_t>(std::lround(color[c]));
  }
  return out;
}

}  // namespace keypose::reconstruct
