#include "views/hull/visual_hull.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "views/hull/mask_field.h"

namespace keypose {
namespace {

// Half of the working resolution is still finer than the grid, and makes the distance transforms
// cheap.
MaskField GrownField(const PreparedView& view, double margin_px) {
  const int level = std::min<int>(1, SizeOf(view.levels) - 1);
  MaskField field = MakeMaskField(view, level);
  const float margin = static_cast<float>(margin_px / (1 << level)) - 0.5f;
  for (float& distance : field.distance) distance -= margin;
  return field;
}

enum class Verdict { kUnseen, kInside, kOutside, kMixed };

// Classifies a ball against one mask. Points outside of the crop are outside of the mask (the crop
// follows the mask's bounds), except beyond the photograph: `field.edges` marks the sides of the
// crop where the mask reaches the photograph's side.
Verdict Judge(const MaskField& field, const Eigen::Vector3d& center, double radius) {
  const std::array<bool, 4>& edges = field.edges;
  const Eigen::Vector3d h = field.from_world * center.homogeneous();
  if (h.z() <= radius) return Verdict::kUnseen;
  const double x = h.x() / h.z(), y = h.y() / h.z();
  const double r = field.focal * radius / (h.z() - radius) + 0.75;
  if ((edges[0] && x < -r) || (edges[1] && x > field.width - 1 + r) || (edges[2] && y < -r) ||
      (edges[3] && y > field.height - 1 + r))
    return Verdict::kUnseen;
  const double cx = std::clamp<double>(x, 0, field.width - 1),
               cy = std::clamp<double>(y, 0, field.height - 1);
  const double beyond = std::hypot(x - cx, y - cy);
  const double d =
      field.distance[static_cast<std::size_t>(std::lround(cy)) * field.width + std::lround(cx)];
  // The distance of a pixel to the border is at most its neighbour's plus the distance between the
  // two.
  if (beyond > 0) {
    const bool photograph_ends = (edges[0] && x < 0) || (edges[1] && x > field.width - 1) ||
                                 (edges[2] && y < 0) || (edges[3] && y > field.height - 1);
    if (photograph_ends) return radius > 0 ? Verdict::kMixed : Verdict::kUnseen;
    return std::max(d, beyond) > r ? Verdict::kOutside : Verdict::kMixed;
  }
  if (d > r) return Verdict::kOutside;
  if (d < -r) return Verdict::kInside;
  return Verdict::kMixed;
}

// For a voxel's centre, which is never mixed.
Verdict JudgePoint(const MaskField& field, const Eigen::Vector3d& x) {
  const std::array<bool, 4>& edges = field.edges;
  const Eigen::Vector3d h = field.from_world * x.homogeneous();
  if (h.z() <= 0) return Verdict::kUnseen;
  const double px = h.x() / h.z(), py = h.y() / h.z();
  if ((edges[0] && px < 0) || (edges[1] && px > field.width - 1) || (edges[2] && py < 0) ||
      (edges[3] && py > field.height - 1))
    return Verdict::kUnseen;
  if (px < 0 || py < 0 || px > field.width - 1 || py > field.height - 1) return Verdict::kOutside;
  return field.distance[static_cast<std::size_t>(std::lround(py)) * field.width + std::lround(px)] >
                 0
             ? Verdict::kOutside
             : Verdict::kInside;
}

class Carver {
 public:
  Carver(const std::vector<PreparedView>& views, const VisualHullOptions& options)
      : options_(options), fields_(views.size()) {
    ParallelFor(std::ssize(views),
                [&](std::int64_t i) { fields_[i] = GrownField(views[i], options.mask_margin_px); });
  }

  // Fills a cube of n^3 voxels, n a power of two.
  VisualHull Carve(const Eigen::Vector3d& low, double side, int n) const {
    VisualHull hull;
    hull.origin = low;
    hull.cell = side / n;
    hull.size = Eigen::Vector3i::Constant(n);
    hull.inside.assign(static_cast<std::size_t>(n) * n * n, 0);
    const int blocks = std::min(n, 8), step = n / blocks;
    ParallelFor(static_cast<std::int64_t>(blocks) * blocks * blocks, [&](std::int64_t i) {
      const int b = static_cast<int>(i);
      Open all;
      all.views.resize(fields_.size());
      std::iota(all.views.begin(), all.views.end(), 0);
      Divide(Eigen::Vector3i(b % blocks, b / blocks % blocks, b / blocks / blocks) * step, step,
             all, &hull);
    });
    return hull;
  }

 private:
  // The views that larger cells have already decided, for all their subcells, and the views still
  // to be tested.
  struct Open {
    int outside = 0, seen = 0;
    std::vector<int> views;
  };

  void Divide(const Eigen::Vector3i& corner, int step, const Open& parent, VisualHull* hull) const {
    const Eigen::Vector3d center =
        hull->origin + hull->cell * (corner.cast<double>() + Eigen::Vector3d::Constant(step * 0.5));
    const bool leaf = step == 1;
    const double radius = leaf ? 0 : hull->cell * step * 0.5 * std::sqrt(3.0);
    Open open{parent.outside, parent.seen, {}};
    int mixed_seen = 0;
    for (const int i : parent.views) {
      const Verdict verdict =
          leaf ? JudgePoint(fields_[i], center) : Judge(fields_[i], center, radius);
      open.outside += verdict == Verdict::kOutside;
      open.seen += verdict == Verdict::kOutside || verdict == Verdict::kInside;
      if (open.outside >= options_.outside_votes) return;
      if (verdict != Verdict::kMixed) continue;
      ++mixed_seen;
      open.views.push_back(i);
    }
    if (open.seen + mixed_seen < 2) return;
    if (leaf || open.views.empty()) return Fill(corner, step, hull);
    const int half = step / 2;
    for (int k = 0; k < 8; ++k)
      Divide(corner + Eigen::Vector3i(k & 1, k >> 1 & 1, k >> 2) * half, half, open, hull);
  }

  static void Fill(const Eigen::Vector3i& corner, int step, VisualHull* hull) {
    for (int z = corner.z(); z < corner.z() + step; ++z)
      for (int y = corner.y(); y < corner.y() + step; ++y) {
        const std::size_t row =
            (static_cast<std::size_t>(z) * hull->size.y() + y) * hull->size.x() + corner.x();
        std::fill_n(hull->inside.begin() + row, step, 1);
      }
  }

  VisualHullOptions options_;
  std::vector<MaskField> fields_;
};

// The point where the rays through the masks' centroids meet, and the masks' extent around it.
struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double radius = 0;
};

Ball ObjectBall(const std::vector<PreparedView>& views) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Identity() * 1e-9;
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const PreparedView& view : views) {
    const Pinhole& camera = view.camera();
    const Eigen::Vector3d ray = camera.Ray(camera.width * 0.5, camera.height * 0.5).normalized();
    const Eigen::Vector3d direction = view.camera_from_world.rotation.conjugate() * ray;
    const Eigen::Matrix3d m = Eigen::Matrix3d::Identity() - direction * direction.transpose();
    a += m;
    b += m * view.Center();
  }
  Ball ball;
  ball.center = a.ldlt().solve(b);
  for (const PreparedView& view : views) {
    const double z = (view.camera_from_world * ball.center).z();
    ball.radius =
        std::max(ball.radius, std::abs(z) * std::hypot(view.camera().width, view.camera().height) *
                                  0.5 / view.camera().fx);
  }
  return ball;
}

struct Bounds {
  Eigen::Vector3i low = Eigen::Vector3i::Constant(std::numeric_limits<int>::max()),
                  high = Eigen::Vector3i::Constant(-1);
};

Bounds OccupiedBounds(const VisualHull& hull) {
  Bounds bounds;
  std::size_t i = 0;
  for (int z = 0; z < hull.size.z(); ++z)
    for (int y = 0; y < hull.size.y(); ++y)
      for (int x = 0; x < hull.size.x(); ++x, ++i)
        if (hull.inside[i]) {
          bounds.low = bounds.low.cwiseMin(Eigen::Vector3i(x, y, z));
          bounds.high = bounds.high.cwiseMax(Eigen::Vector3i(x, y, z));
        }
  return bounds;
}

VisualHull Cropped(const VisualHull& hull, const Bounds& bounds) {
  VisualHull out;
  const Eigen::Vector3i low = (bounds.low.array() - 2).max(0),
                        high = (bounds.high.array() + 2).min(hull.size.array() - 1);
  out.cell = hull.cell;
  out.origin = hull.origin + hull.cell * low.cast<double>();
  out.size = high - low + Eigen::Vector3i::Ones();
  out.inside.resize(static_cast<std::size_t>(out.size.x()) * out.size.y() * out.size.z());
  std::size_t i = 0;
  for (int z = 0; z < out.size.z(); ++z)
    for (int y = 0; y < out.size.y(); ++y)
      for (int x = 0; x < out.size.x(); ++x)
        out.inside[i++] = hull.Inside(x + low.x(), y + low.y(), z + low.z());
  return out;
}

// The part of the ray within the grid's box.
bool ClipToGrid(const VisualHull& hull, const Eigen::Vector3d& from,
                const Eigen::Vector3d& direction, double* begin, double* end) {
  *begin = 0;
  *end = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 3; ++k) {
    const double low = hull.origin[k], high = hull.origin[k] + hull.cell * hull.size[k];
    if (std::abs(direction[k]) < 1e-300) {
      if (from[k] < low || from[k] > high) return false;
      continue;
    }
    const double t0 = (low - from[k]) / direction[k], t1 = (high - from[k]) / direction[k];
    *begin = std::max(*begin, std::min(t0, t1));
    *end = std::min(*end, std::max(t0, t1));
  }
  return *begin < *end;
}

}  // namespace

bool VisualHull::Contains(const Eigen::Vector3d& x) const {
  const Eigen::Vector3d p = (x - origin) / cell;
  return Inside(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                static_cast<int>(std::floor(p.z())));
}

std::optional<VisualHull::Interval> VisualHull::March(const Eigen::Vector3d& from,
                                                      const Eigen::Vector3d& direction) const {
  double begin = 0, end = 0;
  if (cell <= 0 || !ClipToGrid(*this, from, direction, &begin, &end)) return std::nullopt;
  const double step = 0.5 * cell / direction.norm();
  const Eigen::Vector3d first = (from + (begin + 0.5 * step) * direction - origin) / cell,
                        next = step / cell * direction;
  // Within the box coordinates are positive except for rounding, so truncation is the floor.
  auto inside_at = [&](int k) {
    return Inside(static_cast<int>(first.x() + k * next.x()),
                  static_cast<int>(first.y() + k * next.y()),
                  static_cast<int>(first.z() + k * next.z()));
  };
  const int count = static_cast<int>((end - begin) / step + 0.5);
  int front = 0, back = count - 1;
  while (front < count && !inside_at(front)) ++front;
  if (front >= count) return std::nullopt;
  while (!inside_at(back)) --back;
  return Interval{begin + front * step, begin + (back + 1) * step};
}

double VisualHull::Volume() const {
  return cell * cell * cell *
         static_cast<double>(std::count(inside.begin(), inside.end(), std::uint8_t{1}));
}

VisualHull CarveVisualHull(const std::vector<PreparedView>& views,
                           const VisualHullOptions& options) {
  if (views.size() < 2)
    throw InputError("dense: the visual hull needs at least 2 views with a mask, there are " +
                     std::to_string(views.size()));
  const char* kNoSpace =
      "dense: the masks have no common space, so there is no object to reconstruct; look at the "
      "masks and at the cameras' poses";
  const Carver carver(views, options);
  const Ball ball = ObjectBall(views);
  Eigen::Vector3d low = ball.center - Eigen::Vector3d::Constant(1.25 * ball.radius);
  double side = 2.5 * ball.radius;
  if (!(side > 0) || !std::isfinite(side)) throw InputError(kNoSpace);
  for (int pass = 0; pass < 2; ++pass) {  // fit the box to what remains
    const VisualHull coarse = carver.Carve(low, side, 64);
    const Bounds bounds = OccupiedBounds(coarse);
    if (bounds.high.x() < 0) throw InputError(kNoSpace);
    const Eigen::Vector3d a =
        coarse.origin + coarse.cell * (bounds.low.cast<double>().array() - 1).matrix();
    const Eigen::Vector3d b =
        coarse.origin + coarse.cell * (bounds.high.cast<double>().array() + 2).matrix();
    side = (b - a).maxCoeff();
    low = 0.5 * (a + b) - Eigen::Vector3d::Constant(0.5 * side);
  }
  int n = 8;
  while (n < options.resolution) n *= 2;
  // The octree needs a power of two; a larger cube keeps the requested voxel size.
  const double grown = side * n / options.resolution;
  const VisualHull fine =
      carver.Carve(low - Eigen::Vector3d::Constant(0.5 * (grown - side)), grown, n);
  const Bounds bounds = OccupiedBounds(fine);
  if (bounds.high.x() < 0) throw InputError(kNoSpace);
  return Cropped(fine, bounds);
}

PointCloud HullSurface(const VisualHull& hull) {
  std::vector<Eigen::Vector3d> points, normals;
  for (int z = 0; z < hull.size.z(); ++z)
    for (int y = 0; y < hull.size.y(); ++y)
      for (int x = 0; x < hull.size.x(); ++x) {
        if (!hull.Inside(x, y, z)) continue;
        if (hull.Inside(x + 1, y, z) && hull.Inside(x - 1, y, z) && hull.Inside(x, y + 1, z) &&
            hull.Inside(x, y - 1, z) && hull.Inside(x, y, z + 1) && hull.Inside(x, y, z - 1))
          continue;
        // The occupancy's gradient over a ball of radius three voxels is smooth enough for a
        // normal.
        Eigen::Vector3d normal = Eigen::Vector3d::Zero();
        for (int dz = -3; dz <= 3; ++dz)
          for (int dy = -3; dy <= 3; ++dy)
            for (int dx = -3; dx <= 3; ++dx)
              if (dx * dx + dy * dy + dz * dz <= 10 && hull.Inside(x + dx, y + dy, z + dz))
                normal -= Eigen::Vector3d(dx, dy, dz);
        if (normal.norm() < 1e-9) continue;
        points.push_back(hull.origin + hull.cell * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5));
        normals.push_back(normal.normalized());
      }
  PointCloud cloud;
  cloud.points.resize(SizeOf(points), 3);
  cloud.normals.resize(SizeOf(points), 3);
  for (std::size_t i = 0; i < points.size(); ++i) {
    cloud.points.row(static_cast<int>(i)) = points[i];
    cloud.normals.row(static_cast<int>(i)) = normals[i];
  }
  return cloud;
}

}  // namespace keypose
