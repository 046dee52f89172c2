#include "fit/bending/unfold.h"

#include <Eigen/Geometry>
#include <set>

#include "core/values/size_of.h"

namespace keypose::fit {
namespace {

constexpr int kUnfoldRounds = 60;
// A face counts as flipped when the cosine to its expected normal is below this.
constexpr double kLeastCosine = 0.1;

Eigen::Vector3d Normal(const PointsX3& points, const FacesX3& faces, int f) {
  const Eigen::Vector3d a = points.row(faces(f, 0)), b = points.row(faces(f, 1)),
                        c = points.row(faces(f, 2));
  return (b - a).cross(c - a);
}

bool IsFlipped(const PointsX3& rest, const FacesX3& faces, const std::vector<Eigen::Matrix3d>& maps,
               const PointsX3& points, int f) {
  const Eigen::Matrix3d map = maps[faces(f, 0)] + maps[faces(f, 1)] + maps[faces(f, 2)];
  const Eigen::Vector3d expected = map * Normal(rest, faces, f), now = Normal(points, faces, f);
  return now.dot(expected) < kLeastCosine * now.norm() * expected.norm();
}

std::set<int> VerticesOfFlipped(const PointsX3& rest, const FacesX3& faces,
                                const std::vector<Eigen::Matrix3d>& maps, const PointsX3& points) {
  std::set<int> vertices;
  for (int f = 0; f < faces.rows(); ++f)
    if (IsFlipped(rest, faces, maps, points, f))
      for (int k = 0; k < 3; ++k) vertices.insert(faces(f, k));
  return vertices;
}

std::vector<std::set<int>> Neighbours(const FacesX3& faces, Eigen::Index count) {
  std::vector<std::set<int>> neighbours(count);
  for (int f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      neighbours[faces(f, k)].insert(faces(f, (k + 1) % 3));
      neighbours[faces(f, (k + 1) % 3)].insert(faces(f, k));
    }
  return neighbours;
}

}  // namespace

int FlippedFaces(const PointsX3& rest, const FacesX3& faces,
                 const std::vector<Eigen::Matrix3d>& maps, const PointsX3& points) {
  int count = 0;
  for (int f = 0; f < faces.rows(); ++f) count += IsFlipped(rest, faces, maps, points, f);
  return count;
}

int Unfold(const PointsX3& rest, const FacesX3& faces, const std::vector<Eigen::Matrix3d>& maps,
           PointsX3& points) {
  std::set<int> moved;
  std::vector<std::set<int>> neighbours;
  for (int round = 0; round < kUnfoldRounds; ++round) {
    const std::set<int> vertices = VerticesOfFlipped(rest, faces, maps, points);
    if (vertices.empty()) break;
    if (neighbours.empty()) neighbours = Neighbours(faces, rest.rows());
    // Those around move too, or a cluster of flipped faces would only exchange its places.
    std::set<int> around = vertices;
    for (const int v : vertices) around.insert(neighbours[v].begin(), neighbours[v].end());
    const PointsX3 before = points;
    for (const int v : around) {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      for (const int n : neighbours[v]) {
        const Eigen::Vector3d edge = (rest.row(v) - rest.row(n)).transpose();
        sum += before.row(n).transpose() + 0.5 * (maps[v] + maps[n]) * edge;
      }
      points.row(v) = (sum / SizeOf(neighbours[v])).transpose();
      moved.insert(v);
    }
  }
  return SizeOf(moved);
}

}  // namespace keypose::fit
