#include "motion/root/held_patches.h"

#include "core/values/size_of.h"

namespace keypose::motion {

HeldPatch PatchOf(std::vector<int> vertices) {
  HeldPatch patch;
  for (const int i : vertices)
    patch.centre.emplace_back(i, 1.0 / static_cast<double>(vertices.size()));
  patch.vertices = std::move(vertices);
  return patch;
}

HeldPatches::HeldPatches(const PoissonSystem& system, const std::vector<HeldPatch>& patches)
    : patches_(patches) {
  if (patches.empty()) return;
  Eigen::MatrixXd pulls = Eigen::MatrixXd::Zero(system.vertex_count(), std::ssize(patches));
  for (int p = 0; p < count(); ++p)
    for (const int i : patches[p].vertices)
      pulls(i, p) += 1.0 / static_cast<double>(patches[p].vertices.size());
  columns_ = system.SolveScreened(pulls);
  compliance_ = Eigen::MatrixXd::Zero(count(), count());
  for (int p = 0; p < count(); ++p)
    for (const auto& [vertex, weight] : patches[p].centre)
      compliance_.row(p) += weight * columns_.row(vertex);
}

Eigen::RowVector3d HeldPatches::CentreOf(int patch, const PointOf& point_of) const {
  Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
  for (const auto& [vertex, weight] : patches_[patch].centre) sum += weight * point_of(vertex);
  return sum;
}

Eigen::MatrixXd HeldPatches::Compliance(const std::vector<Goal>& goals) const {
  const Eigen::Index count = std::ssize(goals);
  Eigen::MatrixXd result(count, count);
  for (Eigen::Index a = 0; a < count; ++a)
    for (Eigen::Index b = 0; b < count; ++b)
      result(a, b) = compliance_(goals[a].patch, goals[b].patch);
  return result;
}

}  // namespace keypose::motion
