#include "views/hull/silhouettes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"

namespace keypose {
namespace {

constexpr int kMostVotes = 8;
constexpr double kFarOutside = 1e6;
constexpr double kStandsOut = 0.005;
constexpr double kRaysPerView = 5000;

// Marks the voxels that lie so deep within the hull's margin that all their points are inside of
// all outlines. Most rays end there without a projection.
std::vector<std::uint8_t> DeepVoxels(const VisualHull& hull) {
  constexpr int kDepth = 3;
  std::vector<std::uint8_t> deep = hull.inside, next(deep.size());
  const Eigen::Vector3i size = hull.size;
  const std::array<std::ptrdiff_t, 3> stride = {1, size.x(),
                                                static_cast<std::ptrdiff_t>(size.x()) * size.y()};
  for (int axis = 0; axis < 3; ++axis) {  // a box is the product of three lines
    ParallelFor(size.z(), [&](std::int64_t z) {
      for (int y = 0; y < size.y(); ++y)
        for (int x = 0; x < size.x(); ++x) {
          int at = x;
          if (axis == 1) at = y;
          if (axis == 2) at = static_cast<int>(z);
          const std::ptrdiff_t i = x + y * stride[1] + z * stride[2];
          bool all = at >= kDepth && at < size[axis] - kDepth;
          for (int k = -kDepth; k <= kDepth && all; ++k) all = deep[i + k * stride[axis]] != 0;
          next[i] = all;
        }
    });
    deep.swap(next);
  }
  return deep;
}

struct RayGrid {
  const VisualHull& hull;
  VisualHull deep;  // the same grid with fewer voxels
};

// Whether a ray meets the hull. The grid contains the hull, so only its voxels are tested, the deep
// ones first.
bool Meets(const RayGrid& grid, const Silhouettes& silhouettes, const Eigen::Vector3d& from,
           const Eigen::Vector3d& direction) {
  const auto interval = grid.hull.March(from, direction);
  if (!interval) return false;
  const double step = 0.5 * grid.hull.cell / direction.norm();
  for (double t = interval->front; t <= interval->back; t += 2 * step)
    if (grid.deep.Contains(from + t * direction)) return true;
  for (double t = interval->front; t <= interval->back; t += step) {
    const Eigen::Vector3d x = from + t * direction;
    if (grid.hull.Contains(x) && silhouettes.Within(x, 0)) return true;
  }
  return false;
}

double OverlapOf(const PreparedView& view, const RayGrid& grid, const Silhouettes& silhouettes) {
  const GreyMask& grey = view.levels[0].grey;
  const int step = std::max(
      1, static_cast<int>(std::sqrt(static_cast<double>(grey.data.size()) / kRaysPerView)));
  const Eigen::Matrix3d world_from_camera =
      view.camera_from_world.rotation.conjugate().toRotationMatrix();
  const Eigen::Vector3d center = view.Center();
  std::int64_t both = 0, either = 0;
  for (int y = step / 2; y < grey.height; y += step)
    for (int x = step / 2; x < grey.width; x += step) {
      const bool masked = InMask(*grey.at(x, y));
      const bool hit =
          Meets(grid, silhouettes, center, world_from_camera * view.camera().Ray(x, y));
      both += masked && hit;
      either += masked || hit;
    }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

}  // namespace

Silhouettes::Silhouettes(const std::vector<PreparedView>& views, int outside_votes)
    : fields_(views.size()), votes_(std::clamp(outside_votes, 1, kMostVotes)) {
  ParallelFor(std::ssize(views), [&](std::int64_t i) { fields_[i] = MakeMaskField(views[i], 0); });
}

double Silhouettes::DistanceAt(int view, double x, double y) const {
  const MaskField& field = fields_[view];
  const double cx = std::clamp<double>(x, 0, field.width - 1),
               cy = std::clamp<double>(y, 0, field.height - 1);
  const int x0 = std::min(static_cast<int>(cx), std::max(0, field.width - 2)),
            y0 = std::min(static_cast<int>(cy), std::max(0, field.height - 2));
  const int x1 = std::min(x0 + 1, field.width - 1), y1 = std::min(y0 + 1, field.height - 1);
  const double fx = cx - x0, fy = cy - y0;
  const double inside = (1 - fy) * ((1 - fx) * field.At(x0, y0) + fx * field.At(x1, y0)) +
                        fy * ((1 - fx) * field.At(x0, y1) + fx * field.At(x1, y1));
  const double beyond = std::hypot(x - cx, y - cy);
  return beyond > 0 ? std::max(inside, 0.0) + beyond : inside;
}

Silhouettes::Sighting Silhouettes::See(int view, const Eigen::Vector3d& x) const {
  const MaskField& field = fields_[view];
  const Eigen::Vector3d h = field.from_world * x.homogeneous();
  if (h.z() <= 0) return {};
  const double px = h.x() / h.z(), py = h.y() / h.z();
  if ((field.edges[0] && px < 0) || (field.edges[1] && px > field.width - 1) ||
      (field.edges[2] && py < 0) || (field.edges[3] && py > field.height - 1))
    return {};
  return {true, DistanceAt(view, px, py), h.z() / field.focal};
}

double Silhouettes::Outside(const Eigen::Vector3d& x, int without) const {
  std::array<double, kMostVotes> largest;
  largest.fill(-kFarOutside);
  int seen = 0;
  for (int i = 0; i < views(); ++i) {
    if (i == without) continue;
    const Sighting sighting = See(i, x);
    if (!sighting.seen) continue;
    ++seen;
    double d = sighting.distance;
    for (int k = 0; k < votes_; ++k)
      if (d > largest[k]) std::swap(d, largest[k]);
  }
  return seen < 2 ? kFarOutside : largest[votes_ - 1];
}

bool Silhouettes::Within(const Eigen::Vector3d& x, double limit_px) const {
  // Distances change by at most one per pixel, so far from the limit the nearest pixel's distance
  // is sufficient.
  constexpr double kSure = 1.5;
  int seen = 0, outside = 0;
  for (int i = 0; i < views(); ++i) {
    const MaskField& field = fields_[i];
    const Eigen::Vector3d h = field.from_world.leftCols<3>() * x + field.from_world.col(3);
    if (h.z() > 0) {
      const double inverse = 1 / h.z(), px = h.x() * inverse, py = h.y() * inverse;
      if (px >= 0 && py >= 0 && px <= field.width - 1 && py <= field.height - 1 &&
          field.At(static_cast<int>(px + 0.5), static_cast<int>(py + 0.5)) + kSure < limit_px) {
        ++seen;
        continue;
      }
    }
    const Sighting sighting = See(i, x);
    seen += sighting.seen;
    outside += sighting.seen && sighting.distance > limit_px;
    if (outside >= votes_) return false;
  }
  return seen >= 2;
}

Eigen::Vector3d Silhouettes::OutlineNormal(int view, const Eigen::Vector3d& x) const {
  const MaskField& field = fields_[view];
  const Eigen::Vector3d h = field.from_world * x.homogeneous();
  if (h.z() <= 0) return Eigen::Vector3d::Zero();
  const double px = h.x() / h.z(), py = h.y() / h.z();
  // Differences over five pixels, because the outline has steps of one pixel.
  constexpr double kReach = 2.5;
  const Eigen::Vector2d slope(
      DistanceAt(view, px + kReach, py) - DistanceAt(view, px - kReach, py),
      DistanceAt(view, px, py + kReach) - DistanceAt(view, px, py - kReach));
  if (slope.norm() < 1e-3 * kReach) return Eigen::Vector3d::Zero();
  // The line through (px, py) with this normal, and the plane that projects to it.
  const Eigen::Vector3d line(slope.x(), slope.y(), -slope.x() * px - slope.y() * py);
  return (field.from_world.leftCols<3>().transpose() * line).normalized();
}

double MiddleFootprint(const VisualHull& hull, const Silhouettes& silhouettes) {
  const Eigen::Vector3d middle = hull.origin + 0.5 * hull.cell * hull.size.cast<double>();
  std::vector<double> lengths;
  for (int i = 0; i < silhouettes.views(); ++i)
    lengths.push_back(silhouettes.See(i, middle).footprint);
  return UpperMedian(std::move(lengths));
}

PointCloud ExactHullSurface(const VisualHull& hull, const Silhouettes& silhouettes) {
  constexpr int kHalvings = 10;
  constexpr double kMarginPx = 4;  // more than the margin with which hulls are carved
  const double reach = 3 * hull.cell + kMarginPx * MiddleFootprint(hull, silhouettes);
  PointCloud surface = HullSurface(hull);
  std::vector<char> found(surface.points.rows(), 0);
  ParallelFor(
      surface.points.rows(),
      [&](std::int64_t i) {
        const Eigen::Vector3d x = surface.points.row(i), normal = surface.normals.row(i);
        double inner = -reach, outer = 2 * hull.cell;
        if (silhouettes.Within(x + outer * normal, 0) || !silhouettes.Within(x + inner * normal, 0))
          return;
        for (int k = 0; k < kHalvings; ++k) {
          const double middle = 0.5 * (inner + outer);
          (silhouettes.Within(x + middle * normal, 0) ? inner : outer) = middle;
        }
        surface.points.row(i) = x + inner * normal;
        found[i] = 1;
      },
      64);
  std::vector<int> kept;
  for (std::size_t i = 0; i < found.size(); ++i)
    if (found[i]) kept.push_back(static_cast<int>(i));
  PointCloud out;
  out.points = surface.points(kept, Eigen::all);
  out.normals = surface.normals(kept, Eigen::all);
  return out;
}

HullCheck CheckAgainstHull(const std::vector<PreparedView>& views, const VisualHull& hull,
                           const Silhouettes& silhouettes, double least_iou) {
  HullCheck out;
  out.iou.resize(views.size());
  RayGrid grid{hull, hull};
  grid.deep.inside = DeepVoxels(hull);
  ParallelFor(std::ssize(views),
              [&](std::int64_t i) { out.iou[i] = OverlapOf(views[i], grid, silhouettes); });
  for (const double iou : out.iou) out.mean += iou / static_cast<double>(views.size());
  // Hair or fur lowers the IoU of all views alike, and then no single view is at fault.
  const double limit = std::min(least_iou, UpperMedian(out.iou) - kStandsOut);
  for (std::size_t i = 0; i < views.size(); ++i)
    if (out.iou[i] < limit) out.disagreeing.push_back(views[i].name);
  return out;
}

}  // namespace keypose
