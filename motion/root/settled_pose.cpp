#include "motion/root/settled_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/size_of.h"

namespace keypose::motion {

namespace {

constexpr int kMostSteps = 4;
constexpr double kClose = 1e-5;  // of the volume
/// Volume and holds disturb each other little, so that their steps converge fast.
constexpr int kSweeps = 12;

}  // namespace

struct PoseSettler::Step {
  std::vector<int> patches;
  std::vector<double> along;  // of each part, along its volume field
  Eigen::MatrixXd pulls;      // goals x 3
};

void PoseSettler::KeepVolume(PointsX3& pose, Space& space, Report& report) const {
  if (!volume_ || !volume_->any_closed()) return;
  volume_->Measure(pose, space.state);
  Step step{{}, std::vector<double>(volume_->part_count(), 0.0), {}};
  space.kept.assign(volume_->part_count(), 0);
  for (int p = 0; p < volume_->part_count(); ++p) {
    if (!volume_->Keeps(p, space.state)) continue;
    const double missing = volume_->Wanted(p) - space.state.volume[p];
    report.deviation = std::max(report.deviation, std::abs(missing / volume_->Wanted(p)));
    step.along[p] = volume_->StepFor(p, missing, space.state.slope[p], 0);
    space.kept[p] = step.along[p] != 0 || missing == 0;
    // The field's largest entry is about 1.
    report.volume_move = std::max(report.volume_move, std::abs(step.along[p]));
  }
  Move(step, pose, space);
  space.steps = step.along;
}

bool PoseSettler::HasVolume(const Space& space) const {
  for (int p = 0; p < volume_->part_count(); ++p) {
    if (!space.kept[p]) continue;
    if (std::abs(space.missing[p]) > kClose * std::abs(volume_->Wanted(p))) return false;
  }
  return true;
}

void PoseSettler::FindMissing(const PointsX3& pose, Space& space) const {
  space.missing = volume_->Volumes(pose);
  for (int p = 0; p < volume_->part_count(); ++p)
    space.missing[p] = volume_->Wanted(p) - space.missing[p];
}

void PoseSettler::FindGains(const std::vector<HeldPatches::Goal>& goals, Space& space) const {
  const std::vector<int>& parts = volume_->parts();
  const int count = SizeOf(goals);
  space.gains.setZero(volume_->part_count(), 3 * count);
  for (int i = 0; i < SizeOf(parts) && count > 0; ++i)
    for (int g = 0; g < count; ++g)
      space.gains.block<1, 3>(parts[i], 3 * g) +=
          held_->columns()(i, goals[g].patch) / 6 * space.state.gradient.row(i).head<3>();
}

PoseSettler::Step PoseSettler::StepTo(const std::vector<HeldPatches::Goal>& goals,
                                      const PointsX3& pose, const Space& space) const {
  const int count = SizeOf(goals);
  const bool volume = volume_ && volume_->any_closed();
  const int parts = volume ? volume_->part_count() : 0;
  Step step{{}, std::vector<double>(parts, 0.0), Eigen::MatrixXd::Zero(count, 3)};
  if (count == 0 && !volume) return step;
  Eigen::MatrixXd gaps(count, 3);
  for (int g = 0; g < count; ++g) {
    step.patches.push_back(goals[g].patch);
    gaps.row(g) = goals[g].centre - held_->CentreOf(goals[g].patch, pose);
  }
  Eigen::PartialPivLU<Eigen::MatrixXd> compliance;
  if (count > 0) compliance.compute(held_->Compliance(goals));
  for (int sweep = 0; sweep < (count > 0 && volume ? kSweeps : 1); ++sweep) {
    for (int p = 0; p < parts; ++p) {
      if (!space.kept[p]) continue;
      double missing = space.missing[p];
      for (int g = 0; g < count; ++g)
        missing -= space.gains.block<1, 3>(p, 3 * g).dot(step.pulls.row(g));
      step.along[p] = volume_->StepFor(p, missing, space.state.slope[p], space.steps[p]);
    }
    if (count == 0) break;
    Eigen::MatrixXd left = gaps;
    for (int g = 0; g < count && volume; ++g)
      for (const auto& [vertex, weight] : held_->patch(goals[g].patch).centre)
        left.row(g) -=
            weight * step.along[volume_->parts()[vertex]] * space.state.field.row(vertex);
    step.pulls = compliance.solve(left);
  }
  return step;
}

/// @return the largest displacement by pulls
double PoseSettler::Move(const Step& step, PointsX3& pose, const Space& space) const {
  const bool volume = !step.along.empty();
  const int count = SizeOf(step.patches);
  double largest = 0;
  for (Eigen::Index i = 0; i < pose.rows(); ++i) {
    Eigen::RowVector3d pulled = Eigen::RowVector3d::Zero();
    for (int g = 0; g < count; ++g)
      pulled += held_->columns()(i, step.patches[g]) * step.pulls.row(g);
    largest = std::max(largest, pulled.squaredNorm());
    if (volume) pulled += step.along[volume_->parts()[i]] * space.state.field.row(i);
    pose.row(i) += pulled;
  }
  return std::sqrt(largest);
}

void PoseSettler::Settle(const std::vector<HeldPatches::Goal>& goals, PointsX3& pose, Space& space,
                         Report& report) const {
  const bool volume = volume_ && volume_->any_closed();
  if (volume) {
    FindGains(goals, space);
    FindMissing(pose, space);
  }
  bool again = !goals.empty() || (volume && !HasVolume(space));
  for (int k = 0; k < kMostSteps && again; ++k) {
    const Step step = StepTo(goals, pose, space);
    report.held_move = std::max(report.held_move, Move(step, pose, space));
    if (!volume) return;
    for (int p = 0; p < SizeOf(step.along); ++p) space.steps[p] += step.along[p];
    FindMissing(pose, space);
    again = !HasVolume(space);
  }
}

}  // namespace keypose::motion
