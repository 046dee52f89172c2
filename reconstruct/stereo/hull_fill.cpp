#include "reconstruct/stereo/hull_fill.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

// No record of the data; the tests are on the rendered balls of dense_test.cpp. Sensitivity:
// docs/results/sensitivity.md.
struct HullFillTuning {
  KEYPOSE_TUNED(double, kStereoVoxels, 3);  // voxels; no hull points nearer to stereo points
  // largest share of pixels with a confirmed depth around a hull point that is added
  KEYPOSE_TUNED(double, kConfirmedShare, 0.1);
  KEYPOSE_TUNED(float, kSure, 0.3f);  // confidence; stereo points below do not replace hull points
  // The unseen underside is only added as a band along the border of the seen surface, so that the
  // surface turns inwards where the outlines end. Farther in, the hull is a cone below the true
  // base. [voxels from the nearest stereo point]
  KEYPOSE_TUNED(double, kRimTo, 14);
};

constexpr double kRimFrom = 1;  // voxels
constexpr double kUnseenGrey = 128;

// Statistics over the views that see a point of the hull.
struct ViewStatistics {
  int facing = 0;  // views on this side of the surface, whether occluded or not
  int views = 0;
  int pixels = 0, confirmed = 0;
  Eigen::Vector3d color_sum = Eigen::Vector3d::Zero();
};

void Ask(const PreparedView& view, const DepthBounds& bounds, const std::vector<char>& confirmed,
         const Eigen::Vector3d& point, const Eigen::Vector3d& normal, double cell,
         ViewStatistics* witness) {
  const Eigen::Vector3d x = view.camera_from_world * point;
  const double cosine = (view.Center() - point).normalized().dot(normal);
  witness->facing += cosine > 0.2;
  if (x.z() <= 0 || cosine < 0.2) return;
  const Pinhole& camera = view.camera();
  const Eigen::Vector2d p = camera.Project(x);
  const int px = static_cast<int>(std::lround(p.x())), py = static_cast<int>(std::lround(p.y()));
  if (px < 0 || py < 0 || px >= camera.width || py >= camera.height ||
      !InMask(*view.levels[0].grey.at(px, py)))
    return;
  // Occluded by another part of the hull? The bounds include a margin and the maximum over a window
  // at a coarse level, and the masks were grown.
  const double slack = 6 * cell + (4 + (2 << bounds.shift)) * x.z() / camera.fx;
  const int bx = std::min(px >> bounds.shift, bounds.nearest.width - 1),
            by = std::min(py >> bounds.shift, bounds.nearest.height - 1);
  const double nearest = *bounds.nearest.at(bx, by);
  if (nearest <= 0 || x.z() - 1 / nearest > slack) return;
  const int radius = std::clamp(static_cast<int>(std::lround(camera.fx * cell / x.z())), 1, 8);
  for (int y = std::max(0, py - radius); y <= std::min(camera.height - 1, py + radius); ++y)
    for (int xx = std::max(0, px - radius); xx <= std::min(camera.width - 1, px + radius); ++xx) {
      ++witness->pixels;
      witness->confirmed +=
          !confirmed.empty() && confirmed[static_cast<std::size_t>(y) * camera.width + xx];
    }
  const std::uint8_t* rgb = view.color.at(px, py);
  witness->color_sum += Eigen::Vector3d(rgb[0], rgb[1], rgb[2]);
  ++witness->views;
}

// Which points of the hull are added: seen ones without stereo, and the border of the underside
// that no view sees.
bool Wanted(const ViewStatistics& witness, double stereo_distance, double cell) {
  if (witness.views >= 2)
    return stereo_distance > HullFillTuning::kStereoVoxels * cell &&
           witness.confirmed <= HullFillTuning::kConfirmedShare * witness.pixels;
  return witness.facing == 0 && stereo_distance > kRimFrom * cell &&
         stereo_distance < HullFillTuning::kRimTo * cell;
}

PointCloud SureRows(const PointCloud& stereo) {
  std::vector<int> sure;
  for (int i = 0; i < stereo.points.rows(); ++i)
    if (stereo.confidence[i] >= HullFillTuning::kSure) sure.push_back(i);
  PointCloud out;
  out.points = stereo.points(sure, Eigen::all);
  return out;
}

}  // namespace

PointCloud HullFill(const VisualHull& hull, const Silhouettes& silhouettes,
                    const std::vector<PreparedView>& views, const std::vector<DepthBounds>& bounds,
                    const std::vector<std::vector<char>>& confirmed, const PointCloud& stereo) {
  const PointCloud surface = ExactHullSurface(hull, silhouettes);
  const PointsX3 sure = SureRows(stereo).points;
  const std::unique_ptr<KdTree> tree = sure.rows() ? std::make_unique<KdTree>(sure) : nullptr;
  std::vector<ViewStatistics> witnesses(surface.points.rows());
  std::vector<char> wanted(surface.points.rows(), 0);
  ParallelFor(
      surface.points.rows(),
      [&](std::int64_t i) {
        const Eigen::Vector3d point = surface.points.row(i), normal = surface.normals.row(i);
        const double distance = tree ? std::sqrt(tree->Nearest(point).squared_distance)
                                     : std::numeric_limits<double>::max();
        if (distance < kRimFrom * hull.cell) return;
        for (std::size_t v = 0; v < views.size(); ++v)
          Ask(views[v], bounds[v], confirmed[v], point, normal, hull.cell, &witnesses[i]);
        wanted[i] = Wanted(witnesses[i], distance, hull.cell);
      },
      64);
  std::vector<int> kept;
  for (std::size_t i = 0; i < wanted.size(); ++i)
    if (wanted[i]) kept.push_back(static_cast<int>(i));
  PointCloud out;
  out.points = surface.points(kept, Eigen::all);
  out.normals = surface.normals(kept, Eigen::all);
  out.colors.resize(SizeOf(kept), 3);
  out.confidence = Eigen::VectorXf::Constant(SizeOf(kept), kHullConfidence);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const ViewStatistics& witness = witnesses[kept[k]];
    const Eigen::Vector3d color = witness.views ? Eigen::Vector3d(witness.color_sum / witness.views)
                                                : Eigen::Vector3d::Constant(kUnseenGrey);
    for (int c = 0; c < 3; ++c)
      out.colors(static_cast<int>(k), c) = static_cast<std::uint8_t>(std::lround(color[c]));
  }
  return out;
}

}  // namespace keypose::reconstruct
