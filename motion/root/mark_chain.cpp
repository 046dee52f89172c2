#include "motion/root/mark_chain.h"

#include <algorithm>
#include <cmath>

#include "core/numbers/rotations.h"
#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

/// How far a limb's proportion may be from that of the whole: beyond, a mark is misplaced.
constexpr double kMostUneven = 3;

double SpreadOf(const PointsX3& points) {
  return (points.rowwise() - points.colwise().mean()).norm();
}

}  // namespace

MarkChain::MarkChain(MarkTree tree, const PointsX3& on_template, const PointsX3& on_target,
                     const Eigen::Matrix3d& target_from_template)
    : tree_(std::move(tree)),
      on_template_(on_template),
      on_target_(on_target),
      turn_(target_from_template),
      ratio_(tree_.steps.size(), 1) {
  const double from = SpreadOf(on_template), whole = from > 0 ? SpreadOf(on_target) / from : 1;
  for (const auto& [mark, parent] : tree_.steps) {
    const double d = (on_template.row(mark) - on_template.row(parent)).norm();
    const double own = d > 0 ? (on_target.row(mark) - on_target.row(parent)).norm() / d : whole;
    ratio_[mark] = std::clamp(own, whole / kMostUneven, whole * kMostUneven);
  }
}

PointsX3 MarkChain::At(const PointsX3& on_template, const MarkTurns& turns,
                       const std::vector<Eigen::Quaterniond>& rest_turns) const {
  PointsX3 places = PointsX3::Zero(on_target_.rows(), 3);
  for (const auto& [mark, parent] : tree_.steps) {
    if (mark == parent) continue;
    const Eigen::Matrix3d half =
        turns.body * ExpOf(0.5 * (turns.turns.row(mark) + turns.turns.row(parent)).transpose());
    // The template's own turn: that of the target without its turn at rest.
    const Eigen::Quaterniond back = rest_turns[parent].slerp(0.5, rest_turns[mark]).conjugate();
    const Eigen::Vector3d before = turn_ *
                                   (on_template_.row(mark) - on_template_.row(parent)).transpose(),
                          now =
                              turn_ * (on_template.row(mark) - on_template.row(parent)).transpose(),
                          own = (on_target_.row(mark) - on_target_.row(parent)).transpose();
    places.row(mark) = places.row(parent) +
                       (half * own + ratio_[mark] * (now - half * (back * before))).transpose();
  }
  return places;
}

}  // namespace keypose::motion
