#include "interpolate/maps/face_maps.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"

namespace keypose::interpolation {

namespace {

constexpr double kSliver = 1e-6;

/// A triangle in its own frame: edges (p1-p0, p2-p0) = axes * an upper triangular matrix with a
/// positive diagonal.
struct FlatTriangle {
  Eigen::Matrix3d axes;  // two in the plane, then the normal
  Eigen::Matrix2d edges;
  bool degenerate;
};

FlatTriangle Flatten(const PointsX3& p, const FacesX3& faces, Eigen::Index f) {
  const Eigen::Vector3d a = p.row(faces(f, 1)) - p.row(faces(f, 0)),
                        b = p.row(faces(f, 2)) - p.row(faces(f, 0));
  const Eigen::Vector3d n = a.cross(b);
  const double longest = std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
  FlatTriangle t;
  t.degenerate = !(n.norm() > kSliver * longest);
  if (t.degenerate) return t;
  t.axes.col(0) = a.normalized();
  t.axes.col(2) = n.normalized();
  t.axes.col(1) = t.axes.col(2).cross(t.axes.col(0));
  t.edges << a.norm(), t.axes.col(0).dot(b), 0, t.axes.col(1).dot(b);
  return t;
}

FaceMap MapOf(const FlatTriangle& from, const FlatTriangle& to) {
  FaceMap map;
  map.frame.setZero();
  map.degenerate = from.degenerate || to.degenerate;
  if (map.degenerate) return map;
  const Polar2 polar = PolarOf(to.edges * from.edges.inverse());
  Eigen::Matrix3d in_plane = Eigen::Matrix3d::Identity();
  in_plane.topLeftCorner<2, 2>() << polar.cosine, -polar.sine, polar.sine, polar.cosine;
  map.frame = from.axes.leftCols<2>();
  map.rotation = to.axes * in_plane * from.axes.transpose();
  map.stretch = polar.stretch;
  return map;
}

}  // namespace

Polar2 PolarOf(const Eigen::Matrix2d& j) {
  const double c = j(0, 0) + j(1, 1), s = j(1, 0) - j(0, 1), r = std::hypot(c, s);
  Polar2 polar{c / r, s / r, {}};
  Eigen::Matrix2d rotation;
  rotation << polar.cosine, -polar.sine, polar.sine, polar.cosine;
  const Eigen::Matrix2d p = rotation.transpose() * j;
  polar.stretch = 0.5 * (p + p.transpose());
  return polar;
}

Eigen::Matrix2d PowerOf(const Eigen::Matrix2d& m, double t) {
  const double mean = 0.5 * (m(0, 0) + m(1, 1)), d = 0.5 * (m(0, 0) - m(1, 1)),
               r = std::hypot(d, m(0, 1));
  const double high = mean + r, low = (m(0, 0) * m(1, 1) - m(0, 1) * m(0, 1)) / high;
  const double h = std::pow(high, t), l = std::pow(low, t);
  if (r <= 1e-15 * high) return 0.5 * (h + l) * Eigen::Matrix2d::Identity();
  Eigen::Matrix2d traceless;
  traceless << d, m(0, 1), m(0, 1), -d;
  return 0.5 * (h + l) * Eigen::Matrix2d::Identity() + (0.5 * (h - l) / r) * traceless;
}

double BalancedTime(double t, double x) {
  // Series of log(1 + t (e^x - 1)) / x. Each of its terms keeps tau(t, x) + tau(1-t, -x) = 1. x is
  // bounded so that tau increases with t.
  x = std::clamp(x, -1.0, 1.0);
  return t + t * (1 - t) * x * (0.5 + x * ((1 - 2 * t) / 6 + x * (1 - 6 * t + 6 * t * t) / 24));
}

SegmentMaps FaceMapsOf(const PointsX3& v, const PointsX3& u, const FacesX3& faces) {
  SegmentMaps maps;
  maps.faces.resize(faces.rows());
  ParallelFor(
      faces.rows(),
      [&](std::int64_t f) { maps.faces[f] = MapOf(Flatten(v, faces, f), Flatten(u, faces, f)); },
      512);
  return maps;
}

void ShortestTurns(SegmentMaps& maps) {
  ParallelFor(
      std::ssize(maps.faces),
      [&](std::int64_t f) {
        maps.faces[f].turn = maps.faces[f].degenerate ? Eigen::Vector3d::Zero().eval()
                                                      : LogOf(maps.faces[f].rotation);
      },
      512);
}

}  // namespace keypose::interpolation
