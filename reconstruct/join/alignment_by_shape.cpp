#include <algorithm>
#include <iterator>
#include <tuple>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/join/coloured_cloud.h"
#include "reconstruct/join/model_alignment.h"

namespace keypose::reconstruct {
namespace {

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct JoinByShapeTuning {
  KEYPOSE_TUNED(double, kAnotherTurn, 0.26);  ///< rad: a rival differs by more
  /// of the final distance: that up to which first candidates agree
  KEYPOSE_TUNED(double, kWide, 2);
};

/// One step of trimmed ICP.
/// @return the mean distance of the pairs used
double TrimmedStep(const Cloud& first, const KdTree& tree, const Cloud& second, double kept,
                   Similarity3& first_from_second) {
  std::vector<std::pair<double, Eigen::Index>> order;
  std::vector<int> nearest;
  for (Eigen::Index i = 0; i < second.size(); ++i) {
    const KdTree::Neighbor n =
        tree.Nearest(first_from_second * Eigen::Vector3d(second.points.row(i).transpose()));
    order.emplace_back(n.squared_distance, i);
    nearest.push_back(n.index);
  }
  std::sort(order.begin(), order.end());
  const auto count = static_cast<Eigen::Index>(kept * static_cast<double>(order.size()));
  PointsX3 from(count, 3), to(count, 3);
  double sum = 0;
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto [squared, i] = order[k];
    from.row(k) = second.points.row(i);
    to.row(k) = first.points.row(nearest[i]);
    sum += std::sqrt(squared);
  }
  first_from_second = FitSimilarity(from, to, {}, false);
  return sum / static_cast<double>(count);
}

void Settle(const Cloud& first, const KdTree& tree, const Cloud& second, double kept, int rounds,
            Similarity3& first_from_second) {
  double last = 1e300;
  for (int round = 0; round < rounds; ++round) {
    const double mean = TrimmedStep(first, tree, second, kept, first_from_second);
    if (mean > last * (1 - 1e-4)) break;
    last = mean;
  }
}

struct ShapeCandidate {
  Similarity3 motion;
  double share = 0, rms = 0;
};

/// Candidates from rotations all round, best first.
std::vector<ShapeCandidate> Settled(const Cloud& target, const KdTree& tree, const Cloud& coarse,
                                    double limit, const ShapeAlignmentOptions& options) {
  const Eigen::Vector3d from = coarse.points.colwise().mean(), to = target.points.colwise().mean();
  std::vector<ShapeCandidate> candidates(static_cast<std::size_t>(options.rotations));
  ParallelFor(options.rotations, [&](std::int64_t i) {
    ShapeCandidate& candidate = candidates[i];
    candidate.motion.rotation = Turn(static_cast<int>(i), options.rotations);
    candidate.motion.translation = to - candidate.motion.rotation * from;
    Settle(target, tree, coarse, options.kept, 25, candidate.motion);
    candidate.share = Agreement(target, tree, coarse, candidate.motion,
                                JoinByShapeTuning::kWide * limit, options.max_color)
                          .first;
  });
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const ShapeCandidate& a, const ShapeCandidate& b) { return a.share > b.share; });
  return candidates;
}

}  // namespace

ModelAlignment AlignByShape(const Scene& first, const Scene& second,
                            const ShapeAlignmentOptions& options) {
  constexpr std::size_t kRefined = 16;
  ModelAlignment join;
  if (first.points.size() < 100 || second.points.size() < 100) return join;
  const Cloud target = Decimated(first, 8 * options.fine_points),
              coarse = Decimated(second, options.coarse_points),
              fine = Decimated(second, options.fine_points);
  const KdTree tree(target.points);
  const double limit =
      std::max(options.max_distance * Spread(target.points), 2 * Spacing(target, tree));
  std::vector<ShapeCandidate> candidates = Settled(target, tree, coarse, limit, options);
  candidates.resize(std::min(candidates.size(), kRefined));
  ParallelFor(std::ssize(candidates), [&](std::int64_t i) {
    ShapeCandidate& candidate = candidates[i];
    Settle(target, tree, fine, options.kept, 60, candidate.motion);
    std::tie(candidate.share, candidate.rms) =
        Agreement(target, tree, fine, candidate.motion, limit, options.max_color);
  });
  std::stable_sort(
      candidates.begin(), candidates.end(),
      [](const ShapeCandidate& a, const ShapeCandidate& b) { return a.share > b.share; });
  const ShapeCandidate& best = candidates.front();
  double rival = 0;
  for (const ShapeCandidate& candidate : candidates)
    if (AngleBetween(candidate.motion, best.motion) > JoinByShapeTuning::kAnotherTurn)
      rival = std::max(rival, candidate.share);
  join.first_from_second = best.motion;
  Polish(target, tree, Decimated(second, 8 * options.fine_points), limit, options.max_color, false,
         join.first_from_second);
  join.pairs = SizeOf(fine);
  join.agreeing = static_cast<int>(std::lround(best.share * static_cast<double>(fine.size())));
  join.rms = best.rms;
  join.found = best.share >= options.min_share && rival <= options.max_rival * best.share;
  return join;
}

}  // namespace keypose::reconstruct
