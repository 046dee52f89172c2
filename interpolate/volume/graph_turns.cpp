#include "interpolate/volume/graph_turns.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <numbers>
#include <numeric>
#include <queue>
#include <tuple>

#include "core/numbers/parallel.h"
#include "core/values/tuned.h"
#include "interpolate/maps/face_maps.h"
#include "interpolate/volume/tet_maps.h"

namespace keypose::interpolation {

namespace {

// Chosen on the twisted bars (docs/results/interpolation.md); sensitivity:
// docs/results/sensitivity.md.
struct GraphTurnsTuning {
  KEYPOSE_TUNED(double, kSingularZone, 0.3);  // rad: beyond twice the difference of two rotations
  KEYPOSE_TUNED(int, kSmoothings, 100);       // rounds over neighbours, for smooth axes
  // rad: rotations nearer than this enter the mean rotation of the body
  KEYPOSE_TUNED(double, kSurroundings, 30 * std::numbers::pi / 180);
  // rad: rotations nearer than this count as the same body
  KEYPOSE_TUNED(double, kSameRotation, 10 * std::numbers::pi / 180);
};

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr double kNoAxis = 1e-6;  // rotations below this have no usable axis
constexpr double kLast = 10;      // more than any angle between rotations
constexpr double kLeastKnown = 1e-6;
constexpr std::int64_t kSeeds = 32;
constexpr int kMeanShifts = 10;

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  // Angle of a^T b from the chord, which is accurate near 0.
  return 2 * std::asin(std::min(1.0, (a - b).norm() / std::sqrt(8.0)));
}

/// The squared chord of an angle, to compare rotations without an arc sine.
double ChordOf(double angle) { return 8 * std::pow(std::sin(0.5 * angle), 2); }
bool Within(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b, double chord) {
  return (a - b).squaredNorm() < chord;
}

double WholeTurnsTo(double angle, double goal) {
  return angle + kFullTurn * std::round((goal - angle) / kFullTurn);
}

/// Angle of a rotation's component about an axis, nearest to `goal`.
double AngleAbout(const Eigen::Vector3d& axis, const Eigen::Matrix3d& rotation, double goal) {
  const Eigen::Quaterniond q(rotation);
  return WholeTurnsTo(2 * std::atan2(q.vec().dot(axis), q.w()), goal);
}

Eigen::Vector3d NearestTurn(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& parent,
                            double difference) {
  const Eigen::Vector3d principal = LogOf(rotation);
  const double angle = principal.norm();
  Eigen::Vector3d best = principal;
  if (angle > kNoAxis) {
    const Eigen::Vector3d axis = principal / angle;
    best = WholeTurnsTo(angle, axis.dot(parent)) * axis;
  }
  if ((best - parent).norm() <= 2 * difference + GraphTurnsTuning::kSingularZone ||
      parent.norm() < kNoAxis)
    return best;
  const Eigen::Vector3d axis = parent.normalized();
  return AngleAbout(axis, rotation, parent.norm()) * axis;
}

using Neighbours = std::vector<std::array<int, 4>>;

/// Means over the surroundings. A turn's weight is the certainty of its axis, which is small near
/// whole turns.
std::vector<Eigen::Vector3d> Smoothed(const Neighbours& neighbours,
                                      const std::vector<Eigen::Vector3d>& turns) {
  std::vector<Eigen::Vector4d> sums(turns.size()), next(turns.size());
  for (std::size_t i = 0; i < turns.size(); ++i) {
    const double sine = std::sin(0.5 * turns[i].norm()),
                 known = turns[i].norm() < std::numbers::pi ? 1 : sine * sine + kLeastKnown;
    sums[i] << known * turns[i], known;
  }
  for (int round = 0; round < GraphTurnsTuning::kSmoothings; ++round) {
    ParallelFor(
        std::ssize(turns),
        [&](std::int64_t i) {
          Eigen::Vector4d sum = sums[i];
          int count = 1;
          for (int n : neighbours[i])
            if (n >= 0) {
              sum += sums[n];
              ++count;
            }
          next[i] = sum / count;
        },
        1024);
    sums.swap(next);
  }
  std::vector<Eigen::Vector3d> smooth(turns.size());
  for (std::size_t i = 0; i < turns.size(); ++i) smooth[i] = sums[i].head<3>() / sums[i][3];
  return smooth;
}

/// Long turns get smooth axes; short ones keep their own.
void SplitAboutSmoothAxes(const std::vector<Eigen::Matrix3d>& rotations,
                          const Neighbours& neighbours, LiftedTurns& lifted) {
  const auto longest =
      std::max_element(lifted.turns.begin(), lifted.turns.end(),
                       [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  if (longest == lifted.turns.end() || longest->norm() <= std::numbers::pi) return;
  const std::vector<Eigen::Vector3d> smooth = Smoothed(neighbours, lifted.turns);
  for (std::size_t i = 0; i < rotations.size(); ++i) {
    const double share = std::clamp(lifted.turns[i].norm() / std::numbers::pi - 1, 0.0, 1.0);
    if (share == 0) continue;
    const Eigen::Vector3d wanted = (1 - share) * lifted.turns[i] + share * smooth[i];
    if (!(wanted.norm() > kNoAxis)) continue;
    const Eigen::Vector3d axis = wanted.normalized();
    lifted.turns[i] = AngleAbout(axis, rotations[i], wanted.norm()) * axis;
    lifted.remainders[i] = LogOf(ExpOf(lifted.turns[i]).transpose() * rotations[i]);
  }
}

/// Largest difference between neighbours' turns beyond that of their rotations.
double LargestTear(const std::vector<Eigen::Matrix3d>& rotations, const Neighbours& neighbours,
                   const std::vector<char>& doubtful, const std::vector<Eigen::Vector3d>& turns) {
  double largest = 0;
  for (std::size_t i = 0; i < rotations.size(); ++i)
    for (int n : neighbours[i])
      if (n > static_cast<int>(i) && !doubtful[i] && !doubtful[n])
        largest = std::max(largest,
                           (turns[i] - turns[n]).norm() - AngleBetween(rotations[i], rotations[n]));
  return largest;
}

}  // namespace

LiftedTurns LiftTurns(const std::vector<Eigen::Matrix3d>& rotations, int root,
                      const std::vector<std::array<int, 4>>& neighbours,
                      const std::vector<char>& doubtful) {
  const std::size_t count = rotations.size();
  LiftedTurns lifted;
  lifted.turns.resize(count);
  lifted.remainders.assign(count, Eigen::Vector3d::Zero());
  std::vector<double> ranks(count);
  for (std::size_t i = 0; i < count; ++i) {
    lifted.turns[i] = LogOf(rotations[i]);
    ranks[i] = lifted.turns[i].norm() + (doubtful[i] ? kLast : 0);
  }
  ranks[root] = -1;
  std::vector<int> roots(count);
  std::iota(roots.begin(), roots.end(), 0);
  std::stable_sort(roots.begin(), roots.end(), [&](int a, int b) { return ranks[a] < ranks[b]; });
  std::vector<char> done(count, 0);
  using Link = std::tuple<double, int, int>;  // priority of the visit, node, parent
  std::priority_queue<Link, std::vector<Link>, std::greater<>> open;
  for (int start : roots) {
    if (!done[start]) open.emplace(0.0, start, start);
    while (!open.empty()) {
      const auto [difference, node, parent] = open.top();
      open.pop();
      if (done[node]) continue;
      done[node] = 1;
      if (node != parent)
        lifted.turns[node] = NearestTurn(rotations[node], lifted.turns[parent], difference);
      for (int next : neighbours[node])
        if (next >= 0 && !done[next])
          open.emplace(
              (doubtful[next] ? kLast : 0) + AngleBetween(rotations[node], rotations[next]), next,
              node);
    }
  }
  SplitAboutSmoothAxes(rotations, neighbours, lifted);
  for (std::size_t i = 0; i < count;
       ++i)  // nodes that took their parent's axis have a remainder as well
    if (lifted.remainders[i].isZero(0)) {
      const Eigen::Vector3d left = LogOf(ExpOf(lifted.turns[i]).transpose() * rotations[i]);
      if (left.norm() > 1e-12) lifted.remainders[i] = left;
    }
  lifted.largest_tear = LargestTear(rotations, neighbours, doubtful, lifted.turns);
  return lifted;
}

Body BodyOf(const std::vector<Eigen::Matrix3d>& rotations, const std::vector<double>& weights) {
  const std::int64_t count = std::ssize(rotations), seeds = std::min<std::int64_t>(count, kSeeds);
  std::vector<double> shared(seeds, 0.0);
  const double chord = ChordOf(GraphTurnsTuning::kSameRotation);
  ParallelFor(seeds, [&](std::int64_t s) {
    const Eigen::Matrix3d& seed = rotations[s * count / seeds];
    for (std::int64_t i = 0; i < count; ++i)
      if (Within(seed, rotations[i], chord)) shared[s] += weights[i];
  });
  const std::int64_t best = std::max_element(shared.begin(), shared.end()) - shared.begin();
  const double all = std::accumulate(weights.begin(), weights.end(), 0.0);
  return {static_cast<int>(best * count / seeds), all > 0 ? shared[best] / all : 0};
}

Eigen::Matrix3d MeanAround(int node, const std::vector<Eigen::Matrix3d>& rotations,
                           const std::vector<double>& weights) {
  Eigen::Matrix3d mean = rotations[node];
  const double chord = ChordOf(GraphTurnsTuning::kSurroundings);
  for (int round = 0; round < kMeanShifts; ++round) {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    for (std::size_t i = 0; i < rotations.size(); ++i)
      if (Within(mean, rotations[i], chord)) sum += weights[i] * rotations[i];
    if (!(sum.norm() > 0)) break;
    mean = ClosestRotation(sum);
  }
  return mean;
}

int MiddleOf(const std::vector<Eigen::Vector3d>& turns, const std::vector<double>& weights) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < turns.size(); ++i) mean += weights[i] * turns[i];
  mean /= std::max(std::accumulate(weights.begin(), weights.end(), 0.0),
                   std::numeric_limits<double>::min());
  int middle = 0;
  for (std::size_t i = 1; i < turns.size(); ++i)
    if ((turns[i] - mean).squaredNorm() < (turns[middle] - mean).squaredNorm())
      middle = static_cast<int>(i);
  return middle;
}

}  // namespace keypose::interpolation
