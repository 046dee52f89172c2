#include "motion/root/held_patches.h"

#include <Eigen/LU>

#include "core/size_of.h"

namespace keypose::motion {

HeldPatches::HeldPatches(const PoissonSystem& system, const std::vector<std::vector<int>>& patches)
    : patches_(patches) {
  if (patches.empty()) return;
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(system.vertex_count(), std::ssize(patches));
  for (int p = 0; p < SizeOf(patches); ++p)
    for (int i : patches[p]) rows(i, p) += 1.0 / static_cast<double>(patches[p].size());
  columns_ = system.SolveScreened(rows);
  compliance_ = rows.transpose() * columns_;
}

Eigen::RowVector3d HeldPatches::CentreOf(int patch, const PointsX3& pose) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (int i : patches_[patch]) sum += pose.row(i);
  return sum / static_cast<double>(patches_[patch].size());
}

double HeldPatches::Apply(const std::vector<Goal>& goals, PointsX3& pose) const {
  const Eigen::Index count = std::ssize(goals);
  if (count == 0) return 0;
  Eigen::MatrixXd system(count, count), gaps(count, 3), columns(pose.rows(), count);
  for (Eigen::Index a = 0; a < count; ++a) {
    gaps.row(a) = goals[a].centre - CentreOf(goals[a].patch, pose);
    columns.col(a) = columns_.col(goals[a].patch);
    for (Eigen::Index b = 0; b < count; ++b)
      system(a, b) = compliance_(goals[a].patch, goals[b].patch);
  }
  const PointsX3 move = columns * system.partialPivLu().solve(gaps);
  pose += move;
  return move.rowwise().norm().maxCoeff();
}

}  // namespace keypose::motion
