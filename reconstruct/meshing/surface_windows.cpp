#include "reconstruct/meshing/surface_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <tuple>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3i;

constexpr double kSurelyOutside = 1.5;  // [px] masks have an error of a pixel or so
// [px] points of the cloud farther outside are inconsistent with a window
constexpr double kReach = 2;

using Key = std::tuple<int, int, int>;  // of a lattice point, in cells

class Solid {
 public:
  explicit Solid(const Mesh& mesh)
      : scene_(mesh.points, mesh.faces), normals_(FaceNormals(mesh.points, mesh.faces)) {}

  bool Inside(const Vector3d& x) const {
    int votes = 0;
    for (const Vector3d& direction :
         {Vector3d(0.36, 0.48, 0.80), Vector3d(-0.71, 0.23, 0.66), Vector3d(0.19, -0.87, -0.45)}) {
      const RayScene::Hit hit = scene_.Cast(x, direction);
      votes += hit.face >= 0 && normals_.row(hit.face).dot(direction) > 0;
    }
    return votes >= 2;
  }

  /// The interval of a line from its first to its last intersection with the surface, in its own
  /// units; nothing where it does not intersect it.
  std::array<double, 2> Span(const SightLine& line) const {
    std::array<double, 2> span = {0, 0};
    double from = 0;
    for (int hits = 0; hits < 1000; ++hits) {
      const RayScene::Hit hit = scene_.Cast(line.origin, line.direction, from);
      if (hit.face < 0) break;
      if (hits == 0) span[0] = hit.distance;
      span[1] = hit.distance;
      from = hit.distance * (1 + 1e-6) + 1e-12;
    }
    return span;
  }

 private:
  RayScene scene_;
  PointsX3 normals_;
};

/// Lattice points in the windows, with the outlines' distance there and at adjacent points.
class Windows {
 public:
  Windows(const Solid& solid, const OutsideField& outside, double cell)
      : solid_(solid), outside_(outside), cell_(cell) {}

  void Grow(const std::vector<SightLine>& blocked) {
    std::vector<Key> front;
    for (const SightLine& line : blocked) {
      const std::array<double, 2> span = solid_.Span(line);
      const double step = cell_ / line.direction.norm();
      for (double t = span[0] + step / 2; t < span[1]; t += step)
        Visit(KeyOf(line.origin + t * line.direction), &front);
    }
    while (!front.empty()) {
      const Key at = front.back();
      front.pop_back();
      for (const Key& next : Beside(at)) Visit(next, &front);
    }
  }

  /// One point near each pair of adjacent lattice points inside and outside of the figure, on the
  /// outlines.
  PointCloud Walls() {
    std::map<Key, Vector3d> walls;  // by lattice point in the figure
    std::set<Key> rim = open_;
    for (int ring = 0; ring < 2; ++ring)
      rim = Widened(rim);  // from clearly outside to the outline itself
    for (const Key& at : rim) {
      if (OutsideAt(at) <= 0) continue;
      for (const Key& next : Beside(at)) {
        if (OutsideAt(next) > 0 || walls.count(next) || !solid_.Inside(PlaceOf(next))) continue;
        const double a = OutsideAt(at), b = OutsideAt(next);
        walls[next] = PlaceOf(at) + a / (a - b) * (PlaceOf(next) - PlaceOf(at));
      }
    }
    PointCloud cloud;
    cloud.points.resize(SizeOf(walls), 3);
    cloud.normals.resize(SizeOf(walls), 3);
    int row = 0;
    for (const auto& [key, x] : walls) {
      const Vector3d slope = Slope(x);
      if (slope.norm() < 1e-9) continue;
      cloud.points.row(row) = x;
      cloud.normals.row(row++) = slope.normalized();
    }
    cloud.points.conservativeResize(row, 3);
    cloud.normals.conservativeResize(row, 3);
    return cloud;
  }

  bool Contradicts(const Vector3d& x) const {
    const Key at = KeyOf(x);
    if (open_.count(at)) return outside_(x) > kReach;
    for (const Key& next : Beside(at))
      if (open_.count(next)) return outside_(x) > kReach;
    return false;
  }

 private:
  Key KeyOf(const Vector3d& x) const {
    const Vector3i k = (x / cell_).array().round().cast<int>();
    return {k.x(), k.y(), k.z()};
  }
  Vector3d PlaceOf(const Key& key) const {
    return cell_ * Vector3d(std::get<0>(key), std::get<1>(key), std::get<2>(key));
  }
  static std::array<Key, 6> Beside(const Key& key) {
    const auto [x, y, z] = key;
    return {Key{x + 1, y, z}, {x - 1, y, z}, {x, y + 1, z},
            {x, y - 1, z},    {x, y, z + 1}, {x, y, z - 1}};
  }
  static std::set<Key> Widened(const std::set<Key>& keys) {
    std::set<Key> wide = keys;
    for (const Key& key : keys)
      for (const Key& next : Beside(key)) wide.insert(next);
    return wide;
  }
  double OutsideAt(const Key& key) {
    const auto found = outside_at_.find(key);
    if (found != outside_at_.end()) return found->second;
    return outside_at_[key] = outside_(PlaceOf(key));
  }
  Vector3d Slope(const Vector3d& x) const {
    Vector3d slope;
    for (int c = 0; c < 3; ++c) {
      const Vector3d step = cell_ * Vector3d::Unit(c);
      slope[c] = outside_(x + step) - outside_(x - step);
    }
    return slope;
  }
  void Visit(const Key& key, std::vector<Key>* front) {
    if (!visited_.insert(key).second) return;
    if (OutsideAt(key) <= kSurelyOutside || !solid_.Inside(PlaceOf(key))) return;
    open_.insert(key);
    front->push_back(key);
  }

  const Solid& solid_;
  const OutsideField& outside_;
  double cell_;
  std::set<Key> visited_, open_;
  std::map<Key, double> outside_at_;
};

void Append(const PointCloud& walls, FilteredPoints* to) {
  PointCloud& cloud = to->cloud;
  const KdTree tree(cloud.points);
  const int was = static_cast<int>(cloud.points.rows()),
            more = static_cast<int>(walls.points.rows()), now = was + more;
  std::vector<int> nearest(static_cast<std::size_t>(more));
  for (int i = 0; i < more; ++i) nearest[i] = tree.Nearest(walls.points.row(i)).index;
  cloud.points.conservativeResize(now, 3);
  cloud.normals.conservativeResize(now, 3);
  cloud.points.bottomRows(more) = walls.points;
  cloud.normals.bottomRows(more) = walls.normals;
  to->spacing.conservativeResize(now);
  to->spacing.tail(more).setConstant(to->median_spacing);
  if (to->weights.size()) {
    to->weights.conservativeResize(now);
    to->weights.tail(more).setOnes();
  }
  if (cloud.confidence.size()) {
    cloud.confidence.conservativeResize(now);
    cloud.confidence.tail(more).setOnes();
  }
  if (cloud.colors.rows()) {
    cloud.colors.conservativeResize(now, 3);
    for (int i = 0; i < more; ++i) cloud.colors.row(was + i) = cloud.colors.row(nearest[i]);
  }
}

void Keep(const std::vector<int>& rows, FilteredPoints* of) {
  PointCloud& cloud = of->cloud;
  cloud.points = PointsX3(cloud.points(rows, Eigen::all));
  cloud.normals = PointsX3(cloud.normals(rows, Eigen::all));
  of->spacing = Eigen::VectorXd(of->spacing(rows));
  if (of->weights.size()) of->weights = Eigen::VectorXf(of->weights(rows));
  if (cloud.confidence.size()) cloud.confidence = Eigen::VectorXf(cloud.confidence(rows));
  if (cloud.colors.rows()) cloud.colors = ColorsX3(cloud.colors(rows, Eigen::all));
}

}  // namespace

int AddWindowWalls(const Mesh& surface, const std::vector<SightLine>& blocked,
                   const OutsideField& outside, double cell, FilteredPoints* points) {
  const Solid solid(surface);
  Windows windows(solid, outside, cell);
  windows.Grow(blocked);
  const PointCloud walls = windows.Walls();
  if (walls.points.rows() == 0) return 0;
  std::vector<int> kept;
  for (int i = 0; i < points->cloud.points.rows(); ++i)
    if (!windows.Contradicts(points->cloud.points.row(i))) kept.push_back(i);
  if (SizeOf(kept) < points->cloud.points.rows()) Keep(kept, points);
  Append(walls, points);
  return static_cast<int>(walls.points.rows());
}

std::vector<SightLine> BlockedLines(const Mesh& surface, const std::vector<SightLine>& lines) {
  const std::vector<int> holes = ClosedHoles(surface, lines);
  std::set<int> views;
  std::vector<SightLine> blocked;
  for (const SightLine& line : lines)
    if (std::binary_search(holes.begin(), holes.end(), line.hole)) {
      views.insert(line.view);
      blocked.push_back(line);
    }
  if (SizeOf(views) < kViewsOfAWindow) blocked.clear();
  return blocked;
}

}  // namespace keypose::reconstruct
