#include "core/io/meshes/polygon_cut.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace keypose {
namespace {

using Flat = std::vector<Eigen::Vector2d>;

/// Twice the polygon's area along its mean normal. Source: Newell's method.
Eigen::Vector3d NormalOf(const PointsX3& points, const int* corners, std::size_t count) {
  const Eigen::Vector3d origin = points.row(corners[0]);
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (std::size_t k = 1; k + 1 < count; ++k) {
    const Eigen::Vector3d a = points.row(corners[k]).transpose() - origin,
                          b = points.row(corners[k + 1]).transpose() - origin;
    normal += a.cross(b);
  }
  return normal;
}

/// A corner that turns by less, over the polygon's area, lies on the line between its neighbours.
constexpr double kStraight = 1e-12;

/// Twice the signed area; positive: counter-clockwise.
double Turn(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& c) {
  const Eigen::Vector2d ab = b - a, ac = c - a;
  return ab.x() * ac.y() - ab.y() * ac.x();
}

/// The corners in the plane across the normal, counter-clockwise, with an area of 1/2.
Flat Flattened(const PointsX3& points, const int* corners, std::size_t count,
               const Eigen::Vector3d& normal) {
  const double unit = std::sqrt(normal.norm());
  // Any two axes across the normal that turn the same way.
  const Eigen::Vector3d across = normal.unitOrthogonal(), up = normal.normalized().cross(across);
  Flat flat;
  for (std::size_t k = 0; k < count; ++k) {
    const Eigen::Vector3d place = (points.row(corners[k]) - points.row(corners[0])) / unit;
    flat.emplace_back(place.dot(across), place.dot(up));
  }
  return flat;
}

LocalTriangles FanOf(int count) {
  LocalTriangles triangles;
  for (int k = 1; k + 1 < count; ++k) triangles.push_back({0, k, k + 1});
  return triangles;
}

/// Triangles that face away, or have no area.
std::ptrdiff_t Faults(const Flat& flat, const LocalTriangles& triangles) {
  return std::count_if(triangles.begin(), triangles.end(), [&](const std::array<int, 3>& t) {
    return Turn(flat[t[0]], flat[t[1]], flat[t[2]]) <= kStraight;
  });
}

/// Cuts ears off a polygon in the plane, counter-clockwise.
class EarCutter {
 public:
  explicit EarCutter(Flat flat) : flat_(std::move(flat)), count_(static_cast<int>(flat_.size())) {
    for (int i = 0; i < count_; ++i) {
      before_.push_back(i == 0 ? count_ - 1 : i - 1);
      after_.push_back(i + 1 == count_ ? 0 : i + 1);
    }
  }

  LocalTriangles Cut() {
    LocalTriangles triangles;
    int left = count_, corner = 0, seen = 0;
    while (left > 3 && seen < left) {
      const int next = after_[corner];
      if (IsEar(corner)) {
        triangles.push_back({before_[corner], corner, next});
        after_[before_[corner]] = next;
        before_[next] = before_[corner];
        --left;
        seen = 0;
        corner = after_[next];  // not the neighbour: ears in turn are rounder than a fan
      } else {
        ++seen;
        corner = next;
      }
    }
    for (int k = 2, second = after_[corner]; k < left; ++k, second = after_[second])
      triangles.push_back({corner, second, after_[second]});
    return triangles;
  }

 private:
  bool IsEar(int corner) const {
    const int a = before_[corner], c = after_[corner];
    if (Turn(flat_[a], flat_[corner], flat_[c]) <= kStraight) return false;
    for (int other = after_[c]; other != a; other = after_[other]) {
      if (Turn(flat_[before_[other]], flat_[other], flat_[after_[other]]) > 0) continue;
      if (Holds(a, corner, c, other)) return false;
    }
    return true;
  }

  /// Whether another corner lies in a triangle or on its rim. One at a corner's own place, as of
  /// polygons that touch themselves, does not count.
  bool Holds(int a, int b, int c, int other) const {
    const Eigen::Vector2d& p = flat_[other];
    if (p == flat_[a] || p == flat_[b] || p == flat_[c]) return false;
    return Turn(flat_[a], flat_[b], p) >= 0 && Turn(flat_[b], flat_[c], p) >= 0 &&
           Turn(flat_[c], flat_[a], p) >= 0;
  }

  Flat flat_;
  int count_;
  std::vector<int> before_, after_;
};

}  // namespace

LocalTriangles CutOfPolygon(const PointsX3& points, const int* corners, std::size_t count) {
  if (count < 4) return {};
  const Eigen::Vector3d normal = NormalOf(points, corners, count);
  if (!(normal.norm() > 0)) return {};
  const Flat flat = Flattened(points, corners, count, normal);
  const std::ptrdiff_t faults = Faults(flat, FanOf(static_cast<int>(count)));
  if (faults == 0) return {};
  LocalTriangles cut = EarCutter(flat).Cut();
  if (Faults(flat, cut) >= faults) cut.clear();
  return cut;
}

PolygonCuts::PolygonCuts(const PointsX3& points, const std::vector<int>& corners,
                         const std::vector<std::size_t>& sizes) {
  Cut cut;
  for (const std::size_t size : sizes) {
    if (size > 3) cut.triangles = CutOfPolygon(points, corners.data() + cut.first_corner, size);
    if (!cut.triangles.empty()) cuts_.push_back(cut);
    cut.triangles.clear();
    cut.first_corner += size;
    if (size > 2) cut.first_face += static_cast<Eigen::Index>(size) - 2;
  }
}

void PolygonCuts::Apply(const std::vector<int>& corners, FacesX3* faces) const {
  for (const Cut& cut : cuts_)
    for (std::size_t t = 0; t < cut.triangles.size(); ++t)
      for (int k = 0; k < 3; ++k)
        (*faces)(cut.first_face + static_cast<Eigen::Index>(t), k) =
            corners[cut.first_corner + static_cast<std::size_t>(cut.triangles[t][k])];
}

}  // namespace keypose
