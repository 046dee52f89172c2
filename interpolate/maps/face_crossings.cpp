#include "interpolate/maps/face_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <vector>

#include "core/values/tuned.h"

namespace keypose::interpolation {

namespace {

double Orientation(const Eigen::RowVector3d& a, const Eigen::RowVector3d& b,
                   const Eigen::RowVector3d& c, const Eigen::RowVector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

// Tried on bars that pass through themselves (volumetric_test.cpp); no record of single values.
// Sensitivity: docs/results/sensitivity.md.
struct FaceCrossingTuning {
  KEYPOSE_TUNED(int, kRounds, 16);         // most rounds of smoothing until nothing crosses
  KEYPOSE_TUNED(int, kSmoothings, 5);      // in a round
  KEYPOSE_TUNED(int, kRoundsARing, 3);     // after which another ring of faces is smoothed
  KEYPOSE_TUNED(double, kMostMoved, 0.1);  // share of the vertices
};

/// Whether an edge of face e passes through face f.
bool Pierces(const PointsX3& p, const FacesX3& faces, int e, int f) {
  const Eigen::RowVector3d a = p.row(faces(f, 0)), b = p.row(faces(f, 1)), c = p.row(faces(f, 2));
  for (int k = 0; k < 3; ++k) {
    const Eigen::RowVector3d from = p.row(faces(e, k)), to = p.row(faces(e, (k + 1) % 3));
    if (Orientation(a, b, c, from) * Orientation(a, b, c, to) > 0) continue;
    const double s0 = Orientation(from, to, a, b), s1 = Orientation(from, to, b, c),
                 s2 = Orientation(from, to, c, a);
    if ((s0 > 0 && s1 > 0 && s2 > 0) || (s0 < 0 && s1 < 0 && s2 < 0)) return true;
  }
  return false;
}

bool ShareEdge(const FacesX3& faces, int a, int b) {
  int shared = 0;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) shared += faces(a, i) == faces(b, j);
  return shared >= 2;
}

/// Vertices of these faces and of `rings` rings of faces around them.
std::vector<char> Surroundings(const FacesX3& faces, Eigen::Index vertex_count,
                               const std::vector<std::pair<int, int>>& pairs, int rings) {
  std::vector<char> wanted(vertex_count, 0);
  for (const auto& [a, b] : pairs)
    for (int k = 0; k < 3; ++k) wanted[faces(a, k)] = wanted[faces(b, k)] = 1;
  for (int ring = 0; ring < rings; ++ring) {
    std::vector<char> next = wanted;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      if (wanted[faces(f, 0)] || wanted[faces(f, 1)] || wanted[faces(f, 2)])
        for (int k = 0; k < 3; ++k) next[faces(f, k)] = 1;
    wanted.swap(next);
  }
  return wanted;
}

/// Moves the wanted vertices half-way to the mean of their neighbours, `times` times.
void Smooth(const FacesX3& faces, const std::vector<char>& wanted, int times, PointsX3& points) {
  for (int round = 0; round < times; ++round) {
    PointsX3 sums = PointsX3::Zero(points.rows(), 3);
    Eigen::VectorXd counts = Eigen::VectorXd::Zero(points.rows());
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      for (int k = 0; k < 3; ++k) {
        sums.row(faces(f, k)) += points.row(faces(f, (k + 1) % 3));
        counts[faces(f, k)] += 1;
      }
    for (Eigen::Index i = 0; i < points.rows(); ++i)
      if (wanted[i]) points.row(i) = 0.5 * points.row(i) + 0.5 / counts[i] * sums.row(i);
  }
}

}  // namespace

std::vector<std::pair<int, int>> Crossings(const PointsX3& points, const FacesX3& faces) {
  std::vector<std::pair<int, int>> pairs;
  const Eigen::Index count = faces.rows();
  PointsX3 low(count, 3), high(count, 3);
  for (Eigen::Index f = 0; f < count; ++f) {
    const Eigen::Matrix3d corners = (Eigen::Matrix3d() << points.row(faces(f, 0)),
                                     points.row(faces(f, 1)), points.row(faces(f, 2)))
                                        .finished();
    low.row(f) = corners.colwise().minCoeff();
    high.row(f) = corners.colwise().maxCoeff();
  }
  std::vector<int> order(count), open;
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return low(a, 0) < low(b, 0); });
  for (int f : order) {
    std::erase_if(open, [&](int other) { return high(other, 0) < low(f, 0); });
    for (int other : open)
      if ((low.row(f).array() <= high.row(other).array()).all() &&
          (low.row(other).array() <= high.row(f).array()).all() && !ShareEdge(faces, f, other) &&
          (Pierces(points, faces, f, other) || Pierces(points, faces, other, f)))
        pairs.emplace_back(std::min(f, other), std::max(f, other));
    open.push_back(f);
  }
  return pairs;
}

std::optional<PointsX3> WithoutCrossings(const PointsX3& points, const FacesX3& faces) {
  PointsX3 apart = points;
  for (int round = 0; round < FaceCrossingTuning::kRounds; ++round) {
    const std::vector<std::pair<int, int>> pairs = Crossings(apart, faces);
    if (pairs.empty()) break;
    if (round + 1 == FaceCrossingTuning::kRounds) return std::nullopt;
    Smooth(faces,
           Surroundings(faces, points.rows(), pairs, 1 + round / FaceCrossingTuning::kRoundsARing),
           FaceCrossingTuning::kSmoothings, apart);
  }
  const auto moved = ((apart - points).rowwise().squaredNorm().array() > 0).count();
  if (moved > FaceCrossingTuning::kMostMoved * static_cast<double>(points.rows()))
    return std::nullopt;
  return apart;
}

}  // namespace keypose::interpolation
