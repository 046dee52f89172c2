#include "register/skeleton/skeleton_start.h"

#include <algorithm>
#include <cmath>
#include <ctime>
#include <iterator>
#include <limits>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/tuned.h"
#include "register/parts/parts.h"
#include "register/skeleton/skeleton_motion.h"
#include "register/skeleton/skeleton_tree.h"
#include "register/skeleton/tree_matching.h"

namespace keypose::registration {

namespace {

using Eigen::Vector3d;

constexpr int kProbes = 400;  // number of vertices at which matchings are compared

// Measured on tentacles bent by 60 to 450 degrees and on real pairs (docs/algorithms/register.md);
// no record of single values. Sensitivity: docs/results/sensitivity.md.
struct SkeletonStartTuning {
  KEYPOSE_TUNED(int, kAttempts, 8);  // most matchings of limbs that are computed and compared
  // a matching is not tried when its cost is above kWorthTrying times the best plus kCloseCost
  KEYPOSE_TUNED(double, kWorthTrying, 4);   // factor
  KEYPOSE_TUNED(double, kCloseCost, 0.05);  // cost
  // the best matching is ambiguous if the second scores below kUnsure times its score plus
  // kCloseScore
  KEYPOSE_TUNED(double, kUnsure, 1.25);       // factor
  KEYPOSE_TUNED(double, kCloseScore, 0.002);  // of the diagonal
  KEYPOSE_TUNED(double, kBall, 1.6);          // of the median radius: a clear ball at a thick end
  KEYPOSE_TUNED(double, kBallReach, 1.6);     // of its radius: from its centre to the end
  KEYPOSE_TUNED(double, kWeakBall, 1.2);      // the same where the other body has a clear ball
  KEYPOSE_TUNED(double, kWeakBallReach, 3);   // likewise
};

double CpuSeconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::string PercentText(double share) {
  const double rounded = std::round(1000 * share) / 10;
  std::string text = std::to_string(rounded);
  return text.substr(0, text.find('.') + 2) + " %";
}

/// Mean distance to the target's surface, over the target's diagonal.
double Misfit(const PointsX3& points, const LimbedBody& target) {
  double sum = 0;
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    sum += std::sqrt(target.scene.ClosestPoint(points.row(v)).squared_distance);
  return sum / static_cast<double>(points.rows()) / BoundingDiagonal(target.mesh.points);
}

TreeEvidence Evidence(const LimbedBody& source, const LimbedBody& target,
                      const std::vector<MarkPair>& landmarks, const Similarity3& coarse) {
  TreeEvidence evidence;
  evidence.scale = std::sqrt(SurfaceArea(target.mesh.points, target.mesh.faces) /
                             SurfaceArea(source.mesh.points, source.mesh.faces));
  for (const auto& [from, to] : landmarks) {
    evidence.source_nodes.push_back(source.NodeOf(from));
    evidence.target_nodes.push_back(target.NodeOf(to));
  }
  evidence.source_in_target = Transformed(coarse, source.tree->nodes());
  return evidence;
}

SkeletonStart Refused(const std::string& why) {
  SkeletonStart start;
  start.words = why;
  return start;
}

/// Renumbers the joints of a match after the trees were changed. Joint numbers change, but the
/// nodes of tips do not.
TipMatch Renumbered(const TipMatch& match, const SkeletonTree& source_before,
                    const SkeletonTree& target_before, const SkeletonTree& source,
                    const SkeletonTree& target) {
  const auto find = [](const SkeletonTree& before, int joint, const SkeletonTree& now) {
    const int node = before.joints()[joint].nodes.front();
    for (int tip : now.Tips())
      if (now.joints()[tip].nodes.front() == node) return tip;
    return -1;
  };
  TipMatch result = match;
  result.pairs.clear();
  for (const auto& [a, b] : match.pairs) {
    const int s = find(source_before, a, source), t = find(target_before, b, target);
    if (s >= 0 && t >= 0) result.pairs.emplace_back(s, t);
  }
  return result;
}

/// Moves the start of both trees into the ball at their thick end, where they have one. If only one
/// of them has a clear ball, the other is accepted with weaker limits.
void RootBoth(LimbedBody& source, LimbedBody& target) {
  const bool first = source.tree->RootThickEnd(source.scene, SkeletonStartTuning::kBall,
                                               SkeletonStartTuning::kBallReach),
             second = target.tree->RootThickEnd(target.scene, SkeletonStartTuning::kBall,
                                                SkeletonStartTuning::kBallReach);
  if (first == second) return;
  (first ? target : source)
      .tree->RootThickEnd((first ? target : source).scene, SkeletonStartTuning::kWeakBall,
                          SkeletonStartTuning::kWeakBallReach);
}

PointsX3 SomeVertices(const PointsX3& points) {
  const Eigen::Index stride = std::max<Eigen::Index>(1, points.rows() / kProbes),
                     count = (points.rows() + stride - 1) / stride;
  PointsX3 some(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) some.row(i) = points.row(i * stride);
  return some;
}

/// The result of one matching of limbs.
struct Attempt {
  std::string fault;
  double misfit = 0,
         /// misfit of some vertices and residual of landmarks, both means over the diagonal
      residual = 0;
  PointsX3 points;
  int limbs = 0;
  double Score() const { return misfit + residual; }
};

/// Computes the motion for one matching. Both trees are changed for it and restored afterwards.
Attempt Try(LimbedBody& source, LimbedBody& target, const TipMatch& match,
            const std::vector<MarkPair>& marks, const Similarity3& coarse, double scale) {
  Attempt attempt;
  const SkeletonTree source_before = *source.tree, target_before = *target.tree;
  attempt.fault = Reconcile(*source.tree, *target.tree, match);
  if (attempt.fault.empty()) {
    const TipMatch now =
        Renumbered(match, source_before, target_before, *source.tree, *target.tree);
    if (now.pairs.size() < match.pairs.size())
      attempt.fault = "a limb was lost when the two trees were simplified";
    if (attempt.fault.empty()) {
      const SkeletonMotion motion(source, target, now, marks, coarse, scale);
      attempt.points = motion.Apply(source.mesh.points);
      attempt.limbs = motion.limb_count();
      attempt.misfit = Misfit(SomeVertices(attempt.points), target);
      PointsX3 from(std::ssize(marks), 3);
      for (std::size_t i = 0; i < marks.size(); ++i) from.row(i) = marks[i].first.transpose();
      const PointsX3 moved = motion.Apply(from);
      for (std::size_t i = 0; i < marks.size(); ++i)
        attempt.residual += (moved.row(i).transpose() - marks[i].second).norm() /
                            static_cast<double>(marks.size()) /
                            BoundingDiagonal(target.mesh.points);
      if (!attempt.points.allFinite()) attempt.fault = "the limbs are too short to follow";
    }
  }
  *source.tree = source_before;
  *target.tree = target_before;
  return attempt;
}

/// Distances along limbs cannot distinguish left from right, so the best matchings are computed and
/// compared by their fit to the target.
/// @param best  receives the best one; without limbs, the first fault
/// @return the second best score
double TryMatchings(LimbedBody& source, LimbedBody& target, const std::vector<MarkPair>& marks,
                    const Similarity3& coarse, const TreeEvidence& evidence, Attempt& best) {
  double second = std::numeric_limits<double>::infinity();
  const std::vector<TipMatch> matches =
      MatchTreeTips(*source.tree, *target.tree, evidence, SkeletonStartTuning::kAttempts);
  for (const TipMatch& match : matches) {
    if (match.cost >
        SkeletonStartTuning::kWorthTrying * matches.front().cost + SkeletonStartTuning::kCloseCost)
      break;
    Attempt attempt = Try(source, target, match, marks, coarse, evidence.scale);
    if (!attempt.fault.empty()) {
      if (best.limbs == 0 && best.fault.empty()) best.fault = attempt.fault;
      continue;
    }
    if (best.limbs > 0 && attempt.Score() >= best.Score()) {
      second = std::min(second, attempt.Score());
      continue;
    }
    if (best.limbs > 0) second = best.Score();
    best = std::move(attempt);
  }
  return second;
}

SkeletonStart MatchBodies(LimbedBody& source, LimbedBody& target,
                          const std::vector<MarkPair>& marks, const Similarity3& coarse,
                          const SkeletonOptions& options) {
  RootBoth(source, target);
  const std::size_t tips = source.tree->Tips().size(), other_tips = target.tree->Tips().size();
  const std::string counts = std::to_string(tips) + " ends of limbs on the source and " +
                             std::to_string(other_tips) + " on the target";
  if (static_cast<int>(std::max(tips, other_tips)) > options.max_tips)
    return Refused("skeletons: too many limbs: " + counts);
  if (std::min(tips, other_tips) < 2 || (std::min(tips, other_tips) == 2 && tips != other_tips))
    return Refused("skeletons: the limbs differ: " + counts +
                   "; a landmark on each end of a limb would help other starts");
  const TreeEvidence evidence = Evidence(source, target, marks, coarse);
  Attempt best;
  const double second = TryMatchings(source, target, marks, coarse, evidence, best);
  if (best.limbs == 0)
    return Refused("skeletons: " + best.fault + " (" + counts +
                   "); a landmark on each end of a limb would help other starts");
  SkeletonStart start;
  start.points = best.points;
  start.branches = best.limbs;
  start.ambiguous =
      second < SkeletonStartTuning::kUnsure * best.Score() + SkeletonStartTuning::kCloseScore;
  start.words = "skeletons: matched " + std::to_string(start.branches) + " limbs (" + counts +
                "); vertices are " + PercentText(best.misfit) +
                " of the diagonal off the target's surface";
  if (!marks.empty()) start.words += ", landmarks " + PercentText(best.residual);
  if (start.ambiguous)
    start.words +=
        "; another matching fits nearly as well: a landmark on the end of a limb would decide";
  return start;
}

}  // namespace

SkeletonStart StartFromSkeletons(const Mesh& source, const Mesh& target,
                                 const std::vector<LandmarkGoal>& landmarks,
                                 const Similarity3& target_from_source,
                                 const SkeletonOptions& options, Progress* progress) {
  const double before = CpuSeconds();
  RequireUsable(source, "register: source");
  RequireUsable(target, "register: target");
  std::vector<MarkPair> marks;
  for (const LandmarkGoal& goal : landmarks)
    marks.emplace_back(PositionOf(goal.source, source.points), goal.target);
  SkeletonStart start;
  LimbedBody from(source, options.proxy_faces, progress);
  if (!from.skeleton.fault.empty()) {
    start = Refused("skeletons: the source " + from.skeleton.fault);
  } else {
    LimbedBody to(target, options.proxy_faces, progress);
    start = to.skeleton.fault.empty() ? MatchBodies(from, to, marks, target_from_source, options)
                                      : Refused("skeletons: the target " + to.skeleton.fault);
  }
  if (start.usable()) start.points = MoveLoosePartsWithHost(source, from.loose, start.points);
  start.seconds = CpuSeconds() - before;
  return start;
}

}  // namespace keypose::registration
