#include "interpolate/graph_turns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <queue>
#include <tuple>

#include "core/parallel.h"
#include "interpolate/face_maps.h"

namespace keypose::interpolation {

namespace {

constexpr double kFullTurn = 2 * EIGEN_PI;
constexpr double kNoAxis = 1e-6;  // rotations below this have no usable axis
constexpr double kSingularZone = 0.3;
constexpr double kLast = 10;  // more than any angle between rotations
constexpr int kSmoothings = 20;

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  // Of a^T b: by the chord, which keeps its digits near 0.
  return 2 * std::asin(std::min(1.0, (a - b).norm() / std::sqrt(8.0)));
}

struct Choice {
  Eigen::Vector3d turn;
  bool copied;
};

Choice NearestTurn(const Eigen::Vector3d& principal, const Eigen::Vector3d& parent, double difference) {
  const double angle = principal.norm();
  Eigen::Vector3d best = principal;
  if (angle > kNoAxis) {
    const Eigen::Vector3d axis = principal / angle;
    best = (angle + kFullTurn * std::round((axis.dot(parent) - angle) / kFullTurn)) * axis;
  }
  const bool far = (best - parent).norm() > 2 * difference + kSingularZone;
  return {far ? parent : best, far};
}

/// Copies stand for nodes without an axis of their own: between whole turns of both sides they take the middle way.
void SmoothCopies(const std::vector<std::array<int, 4>>& neighbours, const std::vector<int>& copied, std::vector<Eigen::Vector3d>& turns) {
  std::vector<Eigen::Vector3d> next(copied.size());
  for (int round = 0; round < kSmoothings; ++round) {
    for (std::size_t c = 0; c < copied.size(); ++c) {
      Eigen::Vector3d sum = turns[copied[c]];
      int count = 1;
      for (int n : neighbours[copied[c]])
        if (n >= 0) sum += turns[n], ++count;
      next[c] = sum / count;
    }
    for (std::size_t c = 0; c < copied.size(); ++c) turns[copied[c]] = next[c];
  }
}

}  // namespace

LiftedTurns LiftTurns(const std::vector<Eigen::Matrix3d>& rotations, const std::vector<std::array<int, 4>>& neighbours,
                      const std::vector<char>& doubtful) {
  const std::size_t count = rotations.size();
  LiftedTurns lifted;
  lifted.turns.resize(count);
  lifted.remainders.assign(count, Eigen::Vector3d::Zero());
  for (std::size_t i = 0; i < count; ++i) lifted.turns[i] = LogOf(rotations[i]);
  const auto rank = [&](int i) { return lifted.turns[i].norm() + (doubtful[i] ? kLast : 0.0); };
  std::vector<double> ranks(count);
  for (std::size_t i = 0; i < count; ++i) ranks[i] = rank(static_cast<int>(i));
  std::vector<int> roots(count), copied;
  std::iota(roots.begin(), roots.end(), 0);
  std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return ranks[a] < ranks[b]; });
  std::vector<char> done(count, 0);
  using Link = std::tuple<double, int, int>;  // how much later, node, parent
  std::priority_queue<Link, std::vector<Link>, std::greater<>> open;
  for (int root : roots) {
    if (!done[root]) open.emplace(0.0, root, root);
    while (!open.empty()) {
      const auto [difference, node, parent] = open.top();
      open.pop();
      if (done[node]) continue;
      done[node] = 1;
      if (node != parent) {
        const Choice choice = NearestTurn(lifted.turns[node], lifted.turns[parent], difference);
        lifted.turns[node] = choice.turn;
        if (choice.copied) copied.push_back(node);
      }
      for (int next : neighbours[node])
        if (next >= 0 && !done[next])
          open.emplace((doubtful[next] ? kLast : 0.0) + AngleBetween(rotations[node], rotations[next]), next, node);
    }
  }
  SmoothCopies(neighbours, copied, lifted.turns);
  for (int i : copied) lifted.remainders[i] = LogOf(ExpOf(lifted.turns[i]).transpose() * rotations[i]);
  for (std::size_t i = 0; i < count; ++i)
    for (int n : neighbours[i])
      if (n > static_cast<int>(i) && !doubtful[i] && !doubtful[n])
        lifted.largest_tear =
            std::max(lifted.largest_tear, (lifted.turns[i] - lifted.turns[n]).norm() - AngleBetween(rotations[i], rotations[n]));
  return lifted;
}

}  // namespace keypose::interpolation
