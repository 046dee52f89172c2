#include "register/skeleton/tree_matching.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/values/tuned.h"

namespace keypose::registration {

namespace {

// Measured on tentacles bent by 60 to 450 degrees and on real pairs (docs/algorithms/register.md);
// no record of single values. Costs are without unit: lengths are over the largest distance between
// the target's tips. Sensitivity: docs/results/sensitivity.md.
struct TreeMatchTuning {
  // of a limb's length, from the tip: the part over which thickness is compared
  KEYPOSE_TUNED(double, kTipShare, 0.3);
  // of the tree's total length: longer limbs are never merged
  KEYPOSE_TUNED(double, kMergeLimit, 0.25);
  KEYPOSE_TUNED(double, kLandmarkWeight, 4);     // of squared distances along the tree to landmarks
  KEYPOSE_TUNED(double, kThicknessWeight, 0.2);  // of the squared log ratio of thicknesses
  KEYPOSE_TUNED(double, kPlaceWeight, 0.15);     // of the squared distance of the tips' places
};

/// Distances along the tree between tips and from tips to landmarks, and the limbs' thickness,
/// times `scale`.
void MeasureTips(const SkeletonTree& tree, const std::vector<int>& tips, double scale,
                 const std::vector<int>& mark_nodes, Eigen::MatrixXd& between,
                 Eigen::MatrixXd& to_marks, Eigen::VectorXd& thickness) {
  for (std::size_t i = 0; i < tips.size(); ++i) {
    const Eigen::VectorXd d = scale * tree.DistancesFrom(tips[i]);
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < tips.size(); ++j)
      between(row, static_cast<Eigen::Index>(j)) = d[tree.joints()[tips[j]].nodes.front()];
    for (Eigen::Index m = 0; m < to_marks.cols(); ++m) to_marks(row, m) = d[mark_nodes[m]];
    double sum = 0, count = 0;
    const Limb& limb = tree.limbs()[tree.joints()[tips[i]].limbs.front()];
    for (int n : limb.nodes) {
      if (d[n] > TreeMatchTuning::kTipShare * scale * limb.length) continue;
      sum += scale * tree.radius()[n];
      ++count;
    }
    thickness[row] = sum / count;
  }
}

/// The cost of an assignment of tips.
class TipCosts {
 public:
  TipCosts(const SkeletonTree& s, const SkeletonTree& t, const TreeEvidence& e)
      : source_tips(s.Tips()), target_tips(t.Tips()) {
    const auto rows = std::ssize(source_tips), cols = std::ssize(target_tips);
    const auto marks = std::ssize(e.source_nodes);
    between_source_.resize(rows, rows);
    between_target_.resize(cols, cols);
    single_.setZero(rows, cols);
    Eigen::MatrixXd source_marks(rows, marks), target_marks(cols, marks);
    Eigen::VectorXd source_thickness(rows), target_thickness(cols);
    MeasureTips(s, source_tips, e.scale, e.source_nodes, between_source_, source_marks,
                source_thickness);
    MeasureTips(t, target_tips, 1, e.target_nodes, between_target_, target_marks, target_thickness);
    const double reach = std::max(between_target_.maxCoeff(), std::numeric_limits<double>::min());
    for (Eigen::Index i = 0; i < rows; ++i)
      for (Eigen::Index j = 0; j < cols; ++j) {
        if (marks > 0)
          single_(i, j) += TreeMatchTuning::kLandmarkWeight *
                           (source_marks.row(i) - target_marks.row(j)).squaredNorm() /
                           (reach * reach * marks);
        single_(i, j) += TreeMatchTuning::kThicknessWeight *
                         std::pow(std::log(std::max(source_thickness[i], 1e-9 * reach) /
                                           std::max(target_thickness[j], 1e-9 * reach)),
                                  2);
        const Eigen::RowVector3d from =
            e.source_in_target.row(s.joints()[source_tips[i]].nodes.front());
        single_(i, j) +=
            TreeMatchTuning::kPlaceWeight *
            (from - t.nodes().row(t.joints()[target_tips[j]].nodes.front())).squaredNorm() /
            (reach * reach);
      }
    between_source_ /= reach;
    between_target_ /= reach;
  }

  /// The cost that tip i adds when the tips before it are assigned.
  double Of(const std::vector<int>& target_of, int i) const {
    double cost = single_(i, target_of[i]);
    for (int k = 0; k < i; ++k)
      if (target_of[k] >= 0)
        cost += std::pow(between_source_(i, k) - between_target_(target_of[i], target_of[k]), 2);
    return cost;
  }

  std::vector<int> source_tips, target_tips;

 private:
  Eigen::MatrixXd between_source_, between_target_, single_;
};

struct Search {
  const TipCosts& costs;
  std::size_t keep;
  std::vector<int> target_of;
  std::vector<char> used;
  std::vector<std::pair<double, std::vector<int>>> best;  // ascending
  int may_skip = 0;

  void Go(int i, double cost, int skipped) {
    if (best.size() == keep && cost >= best.back().first) return;
    if (i == std::ssize(target_of)) {
      const auto after =
          std::upper_bound(best.begin(), best.end(), cost,
                           [](double c, const auto& entry) { return c < entry.first; });
      best.emplace(after, cost, target_of);
      if (best.size() > keep) best.pop_back();
      return;
    }
    for (std::size_t j = 0; j < used.size(); ++j) {
      if (used[j]) continue;
      used[j] = 1;
      target_of[i] = static_cast<int>(j);
      Go(i + 1, cost + costs.Of(target_of, i), skipped);
      used[j] = 0;
    }
    target_of[i] = -1;
    if (skipped < may_skip) Go(i + 1, cost, skipped + 1);
  }
};

}  // namespace

std::vector<TipMatch> MatchTreeTips(const SkeletonTree& source, const SkeletonTree& target,
                                    const TreeEvidence& evidence, int keep) {
  const TipCosts costs(source, target, evidence);
  const std::size_t n = costs.source_tips.size(), m = costs.target_tips.size();
  Search search{costs,
                static_cast<std::size_t>(std::max(1, keep)),
                std::vector<int>(n, -1),
                std::vector<char>(m, 0),
                {}};
  search.may_skip = n > m ? static_cast<int>(n - m) : 0;
  search.Go(0, 0, 0);
  std::vector<TipMatch> matches;
  for (const auto& [cost, target_of] : search.best) {
    matches.push_back({{}, cost});
    for (std::size_t i = 0; i < n; ++i)
      if (target_of[i] >= 0)
        matches.back().pairs.emplace_back(costs.source_tips[i], costs.target_tips[target_of[i]]);
  }
  return matches;
}

namespace {

/// Removes all tips except those at the given nodes, one at a time, because joints are renumbered.
void KeepTips(SkeletonTree& tree, const std::vector<int>& nodes) {
  for (bool dropped = true; dropped;) {
    dropped = false;
    for (int tip : tree.Tips()) {
      if (tree.limbs().size() < 2) return;
      if (std::find(nodes.begin(), nodes.end(), tree.joints()[tip].nodes.front()) != nodes.end())
        continue;
      tree.DropTip(tip);
      dropped = true;
      break;
    }
  }
}

std::vector<int> Labels(const SkeletonTree& tree, const std::vector<int>& tip_nodes) {
  std::vector<int> label(tree.joints().size(), -1);
  for (std::size_t j = 0; j < label.size(); ++j)
    for (std::size_t k = 0; k < tip_nodes.size(); ++k)
      if (tree.joints()[j].nodes.front() == tip_nodes[k]) label[j] = static_cast<int>(k);
  return label;
}

/// For each limb, how it divides the tips into two sets, as the bits of the set without tip 0.
std::vector<std::uint32_t> Splits(const SkeletonTree& tree, const std::vector<int>& tip_nodes) {
  const std::vector<int> label = Labels(tree, tip_nodes);
  const std::uint32_t all = (1u << tip_nodes.size()) - 1;
  std::vector<std::uint32_t> splits;
  for (std::size_t l = 0; l < tree.limbs().size(); ++l) {
    const std::uint32_t bits = tree.TipsBeyond(static_cast<int>(l), label);
    splits.push_back(bits & 1 ? all & ~bits : bits);
  }
  return splits;
}

/// Merges limbs whose division of the tips does not occur in the other tree.
/// @return false when such a limb is too long to merge
bool MergeUnknown(SkeletonTree& tree, const std::vector<int>& tips, const SkeletonTree& other,
                  const std::vector<int>& other_tips) {
  const std::vector<std::uint32_t> known = Splits(other, other_tips);
  for (bool merged = true; merged;) {
    merged = false;
    const std::vector<std::uint32_t> splits = Splits(tree, tips);
    for (std::size_t l = 0; l < splits.size() && !merged; ++l) {
      if (std::find(known.begin(), known.end(), splits[l]) != known.end()) continue;
      if (tree.limbs()[l].length > TreeMatchTuning::kMergeLimit * tree.total_length()) return false;
      tree.MergeLimb(static_cast<int>(l));
      merged = true;
    }
  }
  return true;
}

}  // namespace

std::string Reconcile(SkeletonTree& source, SkeletonTree& target, const TipMatch& match) {
  std::vector<int> source_tips, target_tips;
  for (const auto& [a, b] : match.pairs) {
    source_tips.push_back(source.joints()[a].nodes.front());
    target_tips.push_back(target.joints()[b].nodes.front());
  }
  KeepTips(source, source_tips);
  KeepTips(target, target_tips);
  if (!MergeUnknown(source, source_tips, target, target_tips) ||
      !MergeUnknown(target, target_tips, source, source_tips))
    return "the limbs of the two branch off in a different order";
  if (source.limbs().size() != target.limbs().size())
    return "the two have different numbers of limbs";
  return "";
}

}  // namespace keypose::registration
