#include "motion/root/settled_pose.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/values/size_of.h"
#include "motion/reconstruct/point_moves.h"

namespace keypose::motion {

namespace {

constexpr int kMostSteps = 5;
constexpr double kClose = 1e-5;  // of the volume
/// Volume and holds disturb each other little, so that their steps converge fast.
constexpr int kSweeps = 12;

}  // namespace

struct PoseSettler::Step {
  std::vector<int> patches;
  std::vector<double> along;  // of each part, along its volume field
  Eigen::MatrixXd pulls;      // goals x 3
};

/// Brings the pose to its volume, as near as one step does.
PoseSettler::Step PoseSettler::StepToVolume(const PointsX3& pose, Space& space,
                                            Report& report) const {
  static const Eigen::MatrixXd kNoPulls;
  volume_->Measure(pose, held_ ? held_->columns() : kNoPulls, space.state);
  const int parts = volume_->part_count();
  Step step{{}, std::vector<double>(parts, 0.0), {}};
  space.kept.assign(parts, 0);
  space.steps.assign(parts, 0);
  space.missing.assign(parts, 0);
  for (int p = 0; p < parts; ++p) {
    if (!volume_->Keeps(p, space.state)) continue;
    const double missing = space.missing[p] = volume_->Wanted(p) - space.state.volume[p];
    report.deviation = std::max(report.deviation, std::abs(missing / volume_->Wanted(p)));
    step.along[p] = volume_->StepFor(p, missing, space.state.slope[p], 0);
    space.kept[p] = step.along[p] != 0 || missing == 0;
    // The field's largest entry is about 1.
    report.volume_move = std::max(report.volume_move, std::abs(step.along[p]));
  }
  return step;
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

/// Parts x 3 goals: how a step along each part's field moves the points of patches.
Eigen::MatrixXd PoseSettler::MovesOfCentres(const std::vector<HeldPatches::Goal>& goals,
                                            const Space& space) const {
  Eigen::MatrixXd moves = Eigen::MatrixXd::Zero(volume_->part_count(), 3 * std::ssize(goals));
  for (int g = 0; g < SizeOf(goals); ++g)
    for (const auto& [vertex, weight] : held_->patch(goals[g].patch).centre)
      moves.block<1, 3>(volume_->parts()[vertex], 3 * g) += weight * space.state.field.row(vertex);
  return moves;
}

PoseSettler::Step PoseSettler::StepTo(const std::vector<HeldPatches::Goal>& goals,
                                      const PointsX3& pose, const Space& space) const {
  const int count = SizeOf(goals), parts = KeepsVolume() ? volume_->part_count() : 0;
  Step step{{}, std::vector<double>(parts, 0.0), Eigen::MatrixXd::Zero(count, 3)};
  Eigen::MatrixXd gaps(count, 3), moves;
  const PointOf point = [&](int vertex) { return pose.row(vertex); };
  for (int g = 0; g < count; ++g) {
    step.patches.push_back(goals[g].patch);
    gaps.row(g) = goals[g].centre - held_->CentreOf(goals[g].patch, point);
  }
  Eigen::PartialPivLU<Eigen::MatrixXd> compliance;
  if (count > 0) compliance.compute(held_->Compliance(goals));
  if (parts > 0) moves = MovesOfCentres(goals, space);
  for (int sweep = 0; sweep < (count > 0 && parts > 0 ? kSweeps : 1); ++sweep) {
    Eigen::MatrixXd left = gaps;
    for (int p = 0; p < parts; ++p) {
      if (!space.kept[p]) continue;
      double missing = space.missing[p];
      for (int g = 0; g < count; ++g)
        missing -= space.state.gains.block<1, 3>(p, 3 * goals[g].patch).dot(step.pulls.row(g));
      step.along[p] = volume_->StepFor(p, missing, space.state.slope[p], space.steps[p]);
      for (int g = 0; g < count; ++g) left.row(g) -= step.along[p] * moves.block<1, 3>(p, 3 * g);
    }
    if (count > 0) step.pulls = compliance.solve(left);
  }
  return step;
}

/// @return the largest displacement by pulls
double PoseSettler::Move(const Step& step, PointsX3& pose, const Space& space) const {
  PointMoves moves;
  if (!step.along.empty()) {
    moves.field = &space.state.field;
    moves.parts = &volume_->parts();
    moves.along = &step.along;
  }
  if (!step.patches.empty()) moves.columns = &held_->columns();
  moves.pulled = step.patches;
  moves.pulls = step.pulls;
  return MovePoints(moves, pose);
}

void PoseSettler::Settle(const GoalsOf& goals_of, PointsX3& pose, Space& space,
                         Report& report) const {
  const bool volume = KeepsVolume();
  Step step;
  if (volume) step = StepToVolume(pose, space, report);
  const std::vector<HeldPatches::Goal> goals = goals_of([&](int i) {
    Eigen::RowVector3d point = pose.row(i);
    if (volume) point += step.along[volume_->parts()[i]] * space.state.field.row(i);
    return point;
  });
  if (goals.empty() && !volume) return;
  if (!goals.empty()) step = StepTo(goals, pose, space);
  for (int k = 0; k < kMostSteps; ++k) {
    report.held_move = std::max(report.held_move, Move(step, pose, space));
    if (!volume) return;
    for (int p = 0; p < SizeOf(step.along); ++p) space.steps[p] += step.along[p];
    FindMissing(pose, space);
    if (HasVolume(space)) return;
    step = StepTo(goals, pose, space);
  }
}

}  // namespace keypose::motion
