#include "interpolate/turns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <queue>
#include <tuple>

namespace keypose::interpolation {

namespace {

constexpr double kFullTurn = 6.283185307179586;
constexpr double kNoAxis = 1e-6;  // rotations below this have no usable axis
constexpr double kSingularZone = 0.3;
constexpr int kMaxTurns = 4;

std::vector<std::vector<int>> FaceNeighbours(const FacesX3& faces) {
  std::map<std::pair<int, int>, std::vector<int>> sides;
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) sides[std::minmax(faces(f, k), faces(f, (k + 1) % 3))].push_back(static_cast<int>(f));
  std::vector<std::vector<int>> neighbours(faces.rows());
  for (const auto& [edge, at] : sides)
    for (int a : at)
      for (int b : at)
        if (a != b) neighbours[a].push_back(b);
  return neighbours;
}

double AngleBetween(const FaceMap& a, const FaceMap& b) { return LogOf(a.rotation.transpose() * b.rotation).norm(); }

/// The rotation vector of the same rotation that lies nearest to the parent's; the parent's own where none is near, as around whole turns.
Eigen::Vector3d NearestTurn(const Eigen::Vector3d& principal, const Eigen::Vector3d& parent, double difference) {
  const double angle = principal.norm();
  Eigen::Vector3d best = principal;
  for (int k = -kMaxTurns; angle > kNoAxis && k <= kMaxTurns; ++k) {
    const Eigen::Vector3d candidate = (angle + k * kFullTurn) / angle * principal;
    if ((candidate - parent).norm() < (best - parent).norm() - 1e-12) best = candidate;
  }
  return (best - parent).norm() > 2 * difference + kSingularZone ? parent : best;
}

}  // namespace

void MakeTurnsConsistent(const FacesX3& faces, std::vector<FaceMap>& maps) {
  const std::vector<std::vector<int>> neighbours = FaceNeighbours(faces);
  std::vector<int> by_angle(maps.size());
  std::iota(by_angle.begin(), by_angle.end(), 0);
  std::stable_sort(by_angle.begin(), by_angle.end(), [&](int a, int b) { return maps[a].turn.norm() < maps[b].turn.norm(); });
  std::vector<char> done(maps.size(), 0);
  using Entry = std::tuple<double, int, int>;  // difference, face, parent
  for (int root : by_angle) {
    if (done[root]) continue;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    open.emplace(0.0, root, root);
    while (!open.empty()) {
      const auto [difference, face, parent] = open.top();
      open.pop();
      if (done[face]) continue;
      done[face] = 1;
      FaceMap& map = maps[face];
      if (face != parent) map.turn = map.degenerate ? maps[parent].turn : NearestTurn(map.turn, maps[parent].turn, difference);
      for (int next : neighbours[face])
        if (!done[next]) open.emplace(maps[next].degenerate ? 10.0 : AngleBetween(maps[face], maps[next]), next, face);
    }
  }
  for (FaceMap& map : maps)
    if (!map.degenerate) map.remainder = LogOf(ExpOf(map.turn).transpose() * map.rotation);
}

}  // namespace keypose::interpolation
