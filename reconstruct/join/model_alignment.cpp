#include "reconstruct/join/model_alignment.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <random>
#include <set>

#include "core/values/size_of.h"
#include "core/values/tuned.h"

namespace keypose::reconstruct {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct ModelAlignmentTuning {
  /// twice the area of a triangle over the squared spread; smaller ones tell no rotation
  KEYPOSE_TUNED(double, kLeastTriangle, 0.02);
};

using Pairs = std::vector<std::pair<int, int>>;

Similarity3 Fit(const Scene& first, const Scene& second, const Pairs& pairs, bool with_scale) {
  PointsX3 from(std::ssize(pairs), 3), to = from;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    to.row(i) = first.points[pairs[i].first].position.transpose();
    from.row(i) = second.points[pairs[i].second].position.transpose();
  }
  return FitSimilarity(from, to, {}, with_scale);
}

double Distance(const Scene& first, const Scene& second, const std::pair<int, int>& pair,
                const Similarity3& first_from_second) {
  return (first.points[pair.first].position -
          first_from_second * second.points[pair.second].position)
      .norm();
}

Pairs Agreeing(const Scene& first, const Scene& second, const Pairs& pairs,
               const Similarity3& first_from_second, double limit) {
  Pairs agreeing;
  for (const auto& pair : pairs)
    if (Distance(first, second, pair, first_from_second) <= limit) agreeing.push_back(pair);
  return agreeing;
}

/// Root mean square distance of the points from their centroid.
double SpreadOf(const Scene& scene) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const SparsePoint& point : scene.points)
    mean += point.position / static_cast<double>(scene.points.size());
  double sum = 0;
  for (const SparsePoint& point : scene.points) sum += (point.position - mean).squaredNorm();
  return scene.points.empty() ? 0 : std::sqrt(sum / static_cast<double>(scene.points.size()));
}

/// Whether three pairs could be the same triangle: wide enough to determine a rotation, with equal
/// sides in both models (up to one scale, if free).
bool CouldAgree(const Scene& first, const Scene& second, const Pairs& three, double spread,
                double limit, bool with_scale) {
  const auto in_first = [&](int k) { return first.points[three[k % 3].first].position; };
  const auto in_second = [&](int k) { return second.points[three[k % 3].second].position; };
  if ((in_first(1) - in_first(0)).cross(in_first(2) - in_first(0)).norm() <
      ModelAlignmentTuning::kLeastTriangle * spread * spread)
    return false;
  std::array<double, 3> a{}, b{};
  for (int k = 0; k < 3; ++k) {
    a[k] = (in_first(k + 1) - in_first(k)).norm();
    b[k] = (in_second(k + 1) - in_second(k)).norm();
  }
  const double sum = b[0] + b[1] + b[2], ratio = sum > 0 ? (a[0] + a[1] + a[2]) / sum : 0;
  const double scale = with_scale ? ratio : 1;
  for (std::size_t k = 0; k < 3; ++k)
    if (!(std::abs(a[k] - scale * b[k]) <= 2 * limit)) return false;
  return true;
}

}  // namespace

Pairs MatchPoints(const std::vector<TrackElement>& first, const std::vector<TrackElement>& second,
                  const std::vector<PairMatches>& matches) {
  std::map<std::pair<int, int>, int> first_point, second_point;  // by image and feature
  for (const TrackElement& e : first) first_point[{e.image, e.feature}] = e.point;
  for (const TrackElement& e : second) second_point[{e.image, e.feature}] = e.point;
  std::map<std::pair<int, int>, int> votes;
  const auto vote = [&](std::pair<int, int> a, std::pair<int, int> b) {
    const auto in_first = first_point.find(a);
    const auto in_second = second_point.find(b);
    if (in_first != first_point.end() && in_second != second_point.end())
      ++votes[{in_first->second, in_second->second}];
  };
  for (const PairMatches& pair : matches)
    for (const auto& [f, g] : pair.features) {
      vote({pair.first, static_cast<int>(f)}, {pair.second, static_cast<int>(g)});
      vote({pair.second, static_cast<int>(g)}, {pair.first, static_cast<int>(f)});
    }
  std::vector<std::pair<int, std::pair<int, int>>> order;
  for (const auto& [pair, count] : votes) order.emplace_back(-count, pair);
  std::sort(order.begin(), order.end());
  std::set<int> used_first, used_second;
  Pairs pairs;
  for (const auto& [count, pair] : order) {
    if (used_first.contains(pair.first) || used_second.contains(pair.second)) continue;
    used_first.insert(pair.first);
    used_second.insert(pair.second);
    pairs.push_back(pair);
  }
  return pairs;
}

ModelAlignment AlignModels(const Scene& first, const Scene& second, const Pairs& pairs,
                           const AlignmentOptions& options) {
  ModelAlignment join;
  join.pairs = SizeOf(pairs);
  if (join.pairs < std::max(3, options.min_pairs)) return join;
  const double spread = SpreadOf(first), limit = options.max_distance * spread;
  std::mt19937 random(7);
  Pairs best;
  for (int trial = 0; trial < options.trials; ++trial) {
    Pairs three;
    for (int k = 0; k < 3; ++k) three.push_back(pairs[random() % pairs.size()]);
    if (!CouldAgree(first, second, three, spread, limit, options.with_scale)) continue;
    Pairs agreeing =
        Agreeing(first, second, pairs, Fit(first, second, three, options.with_scale), limit);
    if (agreeing.size() > best.size()) best = std::move(agreeing);
  }
  for (int round = 0; round < 10 && best.size() >= 3; ++round) {
    join.first_from_second = Fit(first, second, best, options.with_scale);
    Pairs agreeing = Agreeing(first, second, pairs, join.first_from_second, limit);
    if (agreeing == best) break;
    best = std::move(agreeing);
  }
  join.agreeing = SizeOf(best);
  join.found = join.agreeing >= options.min_pairs;
  double sum = 0;
  for (const auto& pair : best)
    sum += std::pow(Distance(first, second, pair, join.first_from_second), 2);
  if (!best.empty()) join.rms = std::sqrt(sum / static_cast<double>(best.size()));
  return join;
}

}  // namespace keypose::reconstruct
