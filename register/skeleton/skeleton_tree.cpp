#include "register/skeleton/skeleton_tree.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "core/numbers/statistics.h"
#include "core/values/size_of.h"
#include "core/values/tuned.h"

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

double InscribedRadius(const RayScene& surface, const Vector3d& p) {
  return std::sqrt(surface.ClosestPoint(p).squared_distance);
}

/// The contraction gives the centre of a ball only roughly. Improves it: the inscribed radius is
/// largest at the centre.
void CenterBall(const RayScene& surface, Vector3d& centre, double& radius) {
  for (double step = 0.3; step > 0.01;) {
    const RayScene::Foot foot = surface.ClosestPoint(centre);
    const Vector3d moved = centre + step * (centre - foot.point);
    const double r = InscribedRadius(surface, moved);
    if (r > radius) {
      centre = moved;
      radius = r;
    } else {
      step /= 2;
    }
  }
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
  std::vector<double> radii;
  for (int n : run) radii.push_back(radius_[n]);
  std::size_t thickest = 0;
  for (std::size_t k = 0; k < run.size(); ++k)
    if (radius_[run[k]] > radius_[run[thickest]]) thickest = k;
  const int ball = run[thickest];
  const bool at_front = (nodes_.row(ball) - nodes_.row(run.front())).norm() <
                        (nodes_.row(ball) - nodes_.row(run.back())).norm();
  const int end = at_front ? run.front() : run.back();
  if (radius_[ball] < thicker * UpperMedian(std::move(radii)) ||
      (nodes_.row(ball) - nodes_.row(end)).norm() > reach * radius_[ball])
    return false;
  Vector3d centre = nodes_.row(ball);
  CenterBall(surface, centre, radius_[ball]);
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

}  // namespace keypose::registration
