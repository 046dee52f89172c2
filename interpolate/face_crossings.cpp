#include "interpolate/face_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

namespace keypose::interpolation {

namespace {

double Orientation(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b, const Eigen::RowVector3d& c, const Eigen::RowVector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

/// Whether an edge of face e goes through face f.
bool Pierces(const PointsX3& p, const FacesX3& faces, int e, int f) {
  const Eigen::RowVector3d a = p.row(faces(f, 0)), b = p.row(faces(f, 1)), c = p.row(faces(f, 2));
  for (int k = 0; k < 3; ++k) {
    const Eigen::RowVector3d from = p.row(faces(e, k)), to = p.row(faces(e, (k + 1) % 3));
    if (Orientation(a, b, c, from) * Orientation(a, b, c, to) > 0) continue;
    const double s0 = Orientation(from, to, a, b), s1 = Orientation(from, to, b, c), s2 = Orientation(from, to, c, a);
    if ((s0 > 0 && s1 > 0 && s2 > 0) || (s0 < 0 && s1 < 0 && s2 < 0)) return true;
  }
  return false;
}

bool ShareVertex(const FacesX3& faces, int a, int b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (faces(a, i) == faces(b, j)) return true;
  return false;
}

}  // namespace

std::optional<std::pair<int, int>> FirstCrossing(const PointsX3& points, const FacesX3& faces) {
  const Eigen::Index count = faces.rows();
  PointsX3 low(count, 3), high(count, 3);
  for (Eigen::Index f = 0; f < count; ++f) {
    const Eigen::Matrix3d corners =
        (Eigen::Matrix3d() << points.row(faces(f, 0)), points.row(faces(f, 1)), points.row(faces(f, 2))).finished();
    low.row(f) = corners.colwise().minCoeff();
    high.row(f) = corners.colwise().maxCoeff();
  }
  std::vector<int> order(count), open;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return low(a, 0) < low(b, 0); });
  for (int f : order) {
    std::erase_if(open, [&](int other) { return high(other, 0) < low(f, 0); });
    for (int other : open)
      if ((low.row(f).array() <= high.row(other).array()).all() && (low.row(other).array() <= high.row(f).array()).all() &&
          !ShareVertex(faces, f, other) && (Pierces(points, faces, f, other) || Pierces(points, faces, other, f)))
        return std::minmax(f, other);
    open.push_back(f);
  }
  return std::nullopt;
}

}  // namespace keypose::interpolation
