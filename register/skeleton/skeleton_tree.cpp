#include "register/skeleton/skeleton_tree.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/size_of.h"
#include "core/tuned.h"

namespace keypose::registration {

namespace {

using Eigen::Vector3d;
constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr int kGrownNodes = 6;

// Measured on tentacles bent by 60 to 450 degrees and on real pairs (docs/algorithms/register.md);
// no record of single values. Sensitivity: docs/results/sensitivity.md.
struct SkeletonTreeTuning {
  // of an inscribed ball's radius: a branch is pruned when its end is nearer to the ball's centre
  KEYPOSE_TUNED(double, kInside, 1.3);
  // of the tip's radius: points that contracted nearer to the tip belong to it
  KEYPOSE_TUNED(double, kNearTip, 0.5);
  KEYPOSE_TUNED(int, kFewestPoints, 8);     // points of a tip from which a ball there is believed
  KEYPOSE_TUNED(double, kBallGrowth, 1.5);  // least radius of a ball, over that of the tip
};

// On the same data; no record of single values. Costs are without unit: lengths are over the
// largest distance between the target's tips.
struct TreeMatchTuning {
  // of a limb's length, from the tip: the part over which thickness is compared
  KEYPOSE_TUNED(double, kTipShare, 0.3);
  // of the tree's total length: longer limbs are never merged
  KEYPOSE_TUNED(double, kMergeLimit, 0.25);
  KEYPOSE_TUNED(double, kLandmarkWeight, 4);     // of squared distances along the tree to landmarks
  KEYPOSE_TUNED(double, kThicknessWeight, 0.2);  // of the squared log ratio of thicknesses
  KEYPOSE_TUNED(double, kPlaceWeight, 0.15);     // of the squared distance of the tips' places
};

double InscribedRadius(const RayScene& surface, const Vector3d& p) {
  return std::sqrt(surface.ClosestPoint(p).squared_distance);
}

}  // namespace

SkeletonTree::SkeletonTree(const CurveSkeleton& skeleton, const RayScene& surface)
    : nodes_(skeleton.nodes), radius_(nodes_.rows()), neighbors_(nodes_.rows()) {
  for (const auto& [a, b] : skeleton.edges) {
    neighbors_[a].push_back(b);
    neighbors_[b].push_back(a);
  }
  for (Eigen::Index i = 0; i < nodes_.rows(); ++i)
    radius_[i] = InscribedRadius(surface, nodes_.row(i));
  GrowIntoBalls(skeleton, surface);
  alias_.resize(nodes_.rows());
  std::iota(alias_.begin(), alias_.end(), 0);
  merged_.assign(nodes_.rows(), -1);
  Prune();
  Rebuild();
  MergeCloseForks();
}

/// A ball at the end of a limb may contract into its neck. This shows when the mean of the points
/// that contracted to the tip is elsewhere, in a thicker place. Then the limb is extended to there.
void SkeletonTree::GrowIntoBalls(const CurveSkeleton& skeleton, const RayScene& surface) {
  const Eigen::Index count = nodes_.rows();
  for (Eigen::Index tip = 0; tip < count; ++tip) {
    if (neighbors_[tip].size() != 1) continue;
    Vector3d middle = Vector3d::Zero();
    int points = 0;
    for (std::size_t p = 0; p < skeleton.node_of.size(); ++p) {
      if ((nodes_.row(skeleton.node_of[p]) - nodes_.row(tip)).norm() >
          SkeletonTreeTuning::kNearTip * radius_[tip])
        continue;
      middle += skeleton.surface.row(p).transpose();
      ++points;
    }
    if (points < SkeletonTreeTuning::kFewestPoints) continue;
    middle /= points;
    const double way = (middle - nodes_.row(tip).transpose()).norm(),
                 radius = InscribedRadius(surface, middle);
    if (radius < SkeletonTreeTuning::kBallGrowth * radius_[tip] || way < radius_[tip]) continue;
    int last = static_cast<int>(tip);
    const Vector3d start = nodes_.row(tip);
    for (int k = 1; k <= kGrownNodes; ++k) {
      const Eigen::Index fresh = nodes_.rows();
      nodes_.conservativeResize(fresh + 1, 3);
      radius_.conservativeResize(fresh + 1);
      nodes_.row(fresh) = (start + (middle - start) * k / kGrownNodes).transpose();
      radius_[fresh] = InscribedRadius(surface, nodes_.row(fresh));
      neighbors_.push_back({last});
      neighbors_[last].push_back(static_cast<int>(fresh));
      last = static_cast<int>(fresh);
    }
  }
}

/// Merges forks that are closer together than the body is thick.
void SkeletonTree::MergeCloseForks() {
  for (bool merged = true; merged;) {
    merged = false;
    for (std::size_t l = 0; l < limbs_.size() && !merged; ++l) {
      const Joint &a = joints_[limbs_[l].from], &b = joints_[limbs_[l].to];
      if (a.tip() || b.tip() || limbs_[l].length > std::max(a.radius, b.radius)) continue;
      MergeLimb(static_cast<int>(l));
      merged = true;
    }
  }
}

void SkeletonTree::Cut(const std::vector<int>& branch, int at) {
  for (int n : branch) {
    alias_[n] = at;
    neighbors_[n].clear();
  }
  auto& left = neighbors_[at];
  left.erase(std::remove_if(
                 left.begin(), left.end(),
                 [&](int n) { return std::find(branch.begin(), branch.end(), n) != branch.end(); }),
             left.end());
}

bool SkeletonTree::PruneOne() {
  double shortest = kFar;
  std::vector<int> twig;
  int at = -1;
  for (Eigen::Index tip = 0; tip < nodes_.rows(); ++tip) {
    if (neighbors_[tip].size() != 1) continue;
    std::vector<int> branch{static_cast<int>(tip)};
    int next = neighbors_[tip][0];
    double length = (nodes_.row(tip) - nodes_.row(next)).norm();
    while (neighbors_[next].size() == 2) {
      const int after =
          neighbors_[next][0] == branch.back() ? neighbors_[next][1] : neighbors_[next][0];
      length += (nodes_.row(next) - nodes_.row(after)).norm();
      branch.push_back(next);
      next = after;
    }
    if (neighbors_[next].size() < 3 || length >= shortest) continue;
    bool inside = false;
    for (Eigen::Index q = 0; q < nodes_.rows() && !inside; ++q)
      inside =
          !neighbors_[q].empty() &&
          (nodes_.row(q) - nodes_.row(tip)).norm() < SkeletonTreeTuning::kInside * radius_[q] &&
          std::find(branch.begin(), branch.end(), static_cast<int>(q)) == branch.end();
    if (!inside) continue;
    shortest = length;
    twig = branch;
    at = next;
  }
  if (at >= 0) Cut(twig, at);
  return at >= 0;
}

void SkeletonTree::Prune() {
  while (PruneOne()) {
  }
}

/// Rebuilds limbs and joints from the neighbours and the merged groups.
void SkeletonTree::Rebuild() {
  limbs_.clear();
  joints_.clear();
  std::vector<int> joint(nodes_.rows(), -1), of_group(groups_, -1);
  for (Eigen::Index i = 0; i < nodes_.rows(); ++i) {
    if (neighbors_[i].empty() || (merged_[i] < 0 && neighbors_[i].size() == 2)) continue;
    int& id = merged_[i] < 0 ? joint[i] : of_group[merged_[i]];
    if (id < 0) {
      id = SizeOf(joints_);
      joints_.emplace_back();
    }
    joint[i] = id;
    joints_[id].nodes.push_back(static_cast<int>(i));
    joints_[id].radius = std::max(joints_[id].radius, radius_[i]);
  }
  for (std::size_t j = 0; j < joints_.size(); ++j)
    for (int start : joints_[j].nodes)
      for (int next : neighbors_[start]) {
        if (joint[next] == static_cast<int>(j)) continue;
        Limb limb;
        limb.from = static_cast<int>(j);
        limb.nodes = {start, next};
        while (joint[limb.nodes.back()] < 0) {
          const int here = limb.nodes.back(), before = limb.nodes[limb.nodes.size() - 2];
          limb.nodes.push_back(neighbors_[here][0] == before ? neighbors_[here][1]
                                                             : neighbors_[here][0]);
        }
        limb.to = joint[limb.nodes.back()];
        if (limb.to < limb.from) continue;  // count each limb once
        for (std::size_t k = 1; k < limb.nodes.size(); ++k)
          limb.length += (nodes_.row(limb.nodes[k]) - nodes_.row(limb.nodes[k - 1])).norm();
        joints_[limb.from].limbs.push_back(SizeOf(limbs_));
        joints_[limb.to].limbs.push_back(SizeOf(limbs_));
        limbs_.push_back(std::move(limb));
      }
}

std::vector<int> SkeletonTree::Tips() const {
  std::vector<int> tips;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (joints_[j].tip()) tips.push_back(static_cast<int>(j));
  return tips;
}

double SkeletonTree::total_length() const {
  double sum = 0;
  for (const Limb& limb : limbs_) sum += limb.length;
  return sum;
}

Eigen::VectorXd SkeletonTree::DistancesFrom(int joint) const {
  Eigen::VectorXd d = Eigen::VectorXd::Constant(nodes_.rows(), kFar);
  std::vector<int> stack = joints_[joint].nodes;
  for (int n : stack) d[n] = 0;
  while (!stack.empty()) {
    const int n = stack.back();
    stack.pop_back();
    for (int m : neighbors_[n]) {
      const double further = d[n] + (nodes_.row(n) - nodes_.row(m)).norm();
      if (!(further < d[m])) continue;
      d[m] = further;
      stack.push_back(m);
    }
  }
  for (std::size_t i = 0; i < alias_.size(); ++i) {
    int n = static_cast<int>(i);
    while (alias_[n] != n) n = alias_[n];
    d[static_cast<Eigen::Index>(i)] = d[n];
  }
  return d;
}

NodePlace SkeletonTree::PlaceOf(int node) const {
  while (alias_[node] != node) node = alias_[node];
  NodePlace place;
  for (std::size_t j = 0; j < joints_.size(); ++j)
    if (std::find(joints_[j].nodes.begin(), joints_[j].nodes.end(), node) !=
        joints_[j].nodes.end()) {
      place.joint = static_cast<int>(j);
      return place;
    }
  for (std::size_t l = 0; l < limbs_.size(); ++l) {
    double arc = 0;
    const std::vector<int>& run = limbs_[l].nodes;
    for (std::size_t k = 1; k < run.size(); ++k) {
      arc += (nodes_.row(run[k]) - nodes_.row(run[k - 1])).norm();
      if (run[k] != node) continue;
      place.limb = static_cast<int>(l);
      place.arc = arc;
      return place;
    }
  }
  return place;
}

std::uint32_t SkeletonTree::TipsBeyond(int limb, const std::vector<int>& label) const {
  std::uint32_t bits = 0;
  std::vector<std::pair<int, int>> stack{{limbs_[limb].to, limb}};
  while (!stack.empty()) {
    const auto [joint, came] = stack.back();
    stack.pop_back();
    if (label[joint] >= 0) bits |= 1u << label[joint];
    for (int l : joints_[joint].limbs)
      if (l != came) stack.emplace_back(limbs_[l].from == joint ? limbs_[l].to : limbs_[l].from, l);
  }
  return bits;
}

void SkeletonTree::DropTip(int joint) {
  const Limb& limb = limbs_[joints_[joint].limbs.front()];
  std::vector<int> branch(limb.nodes);
  if (limb.to != joint) std::reverse(branch.begin(), branch.end());
  const int at = branch.front();
  branch.erase(branch.begin());
  for (int n : joints_[joint].nodes)
    if (std::find(branch.begin(), branch.end(), n) == branch.end()) branch.push_back(n);
  Cut(branch, at);
  // Without this limb, merged forks may no longer be a fork.
  if (merged_[at] >= 0) std::replace(merged_.begin(), merged_.end(), int{merged_[at]}, -1);
  Prune();
  Rebuild();
  MergeCloseForks();
}

void SkeletonTree::MergeLimb(int limb) {
  const int group = groups_++;
  for (int n : limbs_[limb].nodes) merged_[n] = group;
  for (int j : {limbs_[limb].from, limbs_[limb].to})
    for (int n : joints_[j].nodes) merged_[n] = group;
  Rebuild();
}

bool SkeletonTree::RootThickEnd(const RayScene& surface, double thicker, double reach) {
  if (limbs_.size() != 1) return false;
  const std::vector<int> run = limbs_[0].nodes;
  std::vector<double> sorted;
  for (int n : run) sorted.push_back(radius_[n]);
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                   sorted.end());
  std::size_t thickest = 0;
  for (std::size_t k = 0; k < run.size(); ++k)
    if (radius_[run[k]] > radius_[run[thickest]]) thickest = k;
  const int ball = run[thickest];
  const bool at_front = (nodes_.row(ball) - nodes_.row(run.front())).norm() <
                        (nodes_.row(ball) - nodes_.row(run.back())).norm();
  const int end = at_front ? run.front() : run.back();
  if (radius_[ball] < thicker * sorted[sorted.size() / 2] ||
      (nodes_.row(ball) - nodes_.row(end)).norm() > reach * radius_[ball])
    return false;
  // The contraction gives the centre of a ball only roughly. Improve it: the inscribed radius is
  // largest at the centre.
  Vector3d centre = nodes_.row(ball);
  for (double step = 0.3; step > 0.01;) {
    const RayScene::Foot foot = surface.ClosestPoint(centre);
    const Vector3d moved = centre + step * (centre - foot.point);
    const double r = InscribedRadius(surface, moved);
    if (r > radius_[ball]) {
      centre = moved;
      radius_[ball] = r;
    } else {
      step /= 2;
    }
  }
  nodes_.row(ball) = centre;
  std::vector<int> cut =
      at_front
          ? std::vector<int>(run.begin(), run.begin() + static_cast<std::ptrdiff_t>(thickest))
          : std::vector<int>(run.begin() + static_cast<std::ptrdiff_t>(thickest) + 1, run.end());
  // The part of the limb between the ball's centre and the end is not reliable, so remove it.
  if (!cut.empty()) Cut(cut, ball);
  Rebuild();
  return true;
}

namespace {

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
    const auto measure = [&](const SkeletonTree& tree, const std::vector<int>& tips, double scale,
                             const std::vector<int>& mark_nodes, Eigen::MatrixXd& between,
                             Eigen::MatrixXd& to_marks, Eigen::VectorXd& thickness) {
      for (std::size_t i = 0; i < tips.size(); ++i) {
        const Eigen::VectorXd d = scale * tree.DistancesFrom(tips[i]);
        const auto row = static_cast<Eigen::Index>(i);
        for (std::size_t j = 0; j < tips.size(); ++j)
          between(row, static_cast<Eigen::Index>(j)) = d[tree.joints()[tips[j]].nodes.front()];
        for (Eigen::Index m = 0; m < marks; ++m) to_marks(row, m) = d[mark_nodes[m]];
        double sum = 0, count = 0;
        const Limb& limb = tree.limbs()[tree.joints()[tips[i]].limbs.front()];
        for (int n : limb.nodes) {
          if (d[n] > TreeMatchTuning::kTipShare * scale * limb.length) continue;
          sum += scale * tree.radius()[n];
          ++count;
        }
        thickness[row] = sum / count;
      }
    };
    measure(s, source_tips, e.scale, e.source_nodes, between_source_, source_marks,
            source_thickness);
    measure(t, target_tips, 1, e.target_nodes, between_target_, target_marks, target_thickness);
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
