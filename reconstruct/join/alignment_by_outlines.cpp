#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"
#include "reconstruct/join/coloured_cloud.h"
#include "reconstruct/join/model_alignment.h"
#include "reconstruct/numerics/simplex_search.h"

namespace keypose::reconstruct {
namespace {

/// Measured on two halves of 16 photographs (docs/algorithms/sfm.md); no record of
/// single values. Sensitivity: docs/results/sensitivity.md.
struct JoinByOutlinesTuning {
  KEYPOSE_TUNED(double, kMost_px, 12);  ///< farther away the gradient of the distance is not useful
  KEYPOSE_TUNED(double, kSameTurn_deg, 10);   ///< candidates nearer to each other are one
  KEYPOSE_TUNED(double, kAnotherTurn, 0.35);  ///< rad: a rival differs by more
};

/// Mean distance of points outside of the masks of a frame, after a motion into that frame.
double MissOf(const PointsX3& points, const Similarity3& into, const Silhouettes& masks) {
  double sum = 0;
  for (Eigen::Index i = 0; i < points.rows(); ++i)
    sum += std::clamp(masks.Outside(into * Eigen::Vector3d(points.row(i).transpose())), 0.0,
                      JoinByOutlinesTuning::kMost_px);
  return sum / static_cast<double>(points.rows());
}

/// Points of both models, for comparing motions.
struct MotionComparison {
  const HalfOutlines& outlines;
  PointsX3 first, second;

  double Miss(const Similarity3& first_from_second) const {
    return 0.5 * (MissOf(second, first_from_second, outlines.first) +
                  MissOf(first, first_from_second.Inverse(), outlines.second));
  }
  /// Distance of the points outside of their own model's outlines.
  double Own() const {
    return 0.5 * (MissOf(first, {}, outlines.first) + MissOf(second, {}, outlines.second));
  }
};

// rotation, shift over the spread, logarithm of the scale
using MotionUnknowns = Eigen::Matrix<double, 7, 1>;

/// A motion, rotated and scaled about `middle` of the second model, and shifted.
Similarity3 Moved(const Similarity3& motion, const Eigen::Vector3d& middle, double spread,
                  const Eigen::VectorXd& by) {
  const Eigen::Vector3d turn = by.head<3>();
  Similarity3 moved = motion;
  if (turn.norm() > 0)
    moved.rotation =
        Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * motion.rotation;
  moved.scale *= std::exp(by(6));
  moved.translation =
      motion * middle + spread * by.segment<3>(3) - moved.scale * (moved.rotation * middle);
  return moved;
}

struct Candidate {
  Similarity3 motion;
  double miss = 0;
};

/// @param size  of the first simplex: 1 for a far start
void Search(const MotionComparison& comparison, double spread, double size, int evaluations,
            Candidate& candidate) {
  const Eigen::Vector3d middle = comparison.second.colwise().mean();
  const MotionUnknowns step =
      size * (MotionUnknowns() << 8 * kDegree, 8 * kDegree, 8 * kDegree, 0.15, 0.15, 0.15, 0.08)
                 .finished();
  const auto cost = [&](const Eigen::VectorXd& by) {
    return comparison.Miss(Moved(candidate.motion, middle, spread, by));
  };
  const Eigen::VectorXd by = MinimizeSimplex(cost, MotionUnknowns::Zero(), step, evaluations);
  candidate.motion = Moved(candidate.motion, middle, spread, by);
  candidate.miss = comparison.Miss(candidate.motion);
}

/// Continues the search from all candidates, and keeps the best `kept` that differ by kSameTurn_deg
/// or more, best first, so that other rotations remain for comparison.
void SearchAll(const MotionComparison& comparison, double spread, double size, int evaluations,
               std::size_t kept, std::vector<Candidate>& candidates) {
  ParallelFor(std::ssize(candidates), [&](std::int64_t i) {
    Search(comparison, spread, size, evaluations, candidates[i]);
  });
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.miss < b.miss; });
  std::vector<Candidate> different;
  for (const Candidate& candidate : candidates) {
    const bool is_new =
        std::none_of(different.begin(), different.end(), [&](const Candidate& other) {
          return AngleBetween(candidate.motion, other.motion) <
                 JoinByOutlinesTuning::kSameTurn_deg * kDegree;
        });
    if (is_new && different.size() < kept) different.push_back(candidate);
  }
  candidates = std::move(different);
}

std::vector<Candidate> Starts(const PointsX3& first, const PointsX3& second, int rotations) {
  const Eigen::Vector3d from = second.colwise().mean(), to = first.colwise().mean();
  std::vector<Candidate> starts(static_cast<std::size_t>(rotations));
  for (int i = 0; i < rotations; ++i) {
    Similarity3& motion = starts[i].motion;
    motion.scale = Spread(first) / Spread(second);
    motion.rotation = Turn(i, rotations);
    motion.translation = to - motion.scale * (motion.rotation * from);
  }
  return starts;
}

}  // namespace

double MissedOutlines(const Scene& first, const Scene& second, const HalfOutlines& outlines,
                      const Similarity3& first_from_second, int points) {
  return MotionComparison{outlines, Decimated(first, points).points,
                          Decimated(second, points).points}
      .Miss(first_from_second);
}

ModelAlignment AlignByOutlines(const Scene& first, const Scene& second,
                               const HalfOutlines& outlines,
                               const OutlineAlignmentOptions& options) {
  constexpr int kPlenty = 16000;
  ModelAlignment join;
  if (first.points.size() < 100 || second.points.size() < 100) return join;
  const Cloud target = Decimated(first, kPlenty), moving = Decimated(second, kPlenty);
  const double spread = Spread(target.points);
  const MotionComparison coarse{outlines, Decimated(first, options.coarse_points).points,
                                Decimated(second, options.coarse_points).points},
      fine{outlines, Decimated(first, options.fine_points).points,
           Decimated(second, options.fine_points).points};
  std::vector<Candidate> candidates = Starts(target.points, moving.points, options.rotations);
  SearchAll(coarse, spread, 1, 80, 40, candidates);
  SearchAll(coarse, spread, 0.5, 150, 8, candidates);
  SearchAll(fine, spread, 0.25, 200, 4, candidates);
  SearchAll(fine, spread, 0.05, 200, 4, candidates);
  const Candidate& best = candidates.front();
  join.rival_miss_px = JoinByOutlinesTuning::kMost_px;
  for (const Candidate& candidate : candidates)
    if (AngleBetween(candidate.motion, best.motion) > JoinByOutlinesTuning::kAnotherTurn)
      join.rival_miss_px = std::min(join.rival_miss_px, candidate.miss);
  const KdTree tree(target.points);
  const double limit = std::max(options.max_distance * spread, 2 * Spacing(target, tree));
  join.first_from_second = best.motion;
  Polish(target, tree, moving, limit, options.max_color, true, join.first_from_second);
  join.miss_px = fine.Miss(join.first_from_second);
  const auto [share, rms] =
      Agreement(target, tree, moving, join.first_from_second, limit, options.max_color);
  join.pairs = SizeOf(moving);
  join.agreeing = static_cast<int>(std::lround(share * static_cast<double>(moving.size())));
  join.rms = rms;
  join.found = join.miss_px <= fine.Own() + options.max_miss_px &&
               join.rival_miss_px >= join.miss_px + options.least_rival_px &&
               share >= options.min_share;
  return join;
}

}  // namespace keypose::reconstruct
