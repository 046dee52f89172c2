// Patches of a surface that are held at given places, by multipliers.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose::motion {

/// Moves poses by the smoothest local displacement that brings the centres of some patches to given
/// places exactly.
///
/// The displacement minimises |grad|^2 + kappa |.|^2, the screened energy of PoissonSystem. Its
/// factor is that of the system, and one column for each patch is solved once; a pose then costs a
/// dense system with one unknown for each patch that is held. Nothing is factored again.
/// Source: Lagrange multipliers by the Schur complement.
class HeldPatches {
 public:
  /// @param system  built with screening; only used here
  /// @param patches  vertices of each, not empty
  HeldPatches(const PoissonSystem& system, const std::vector<std::vector<int>>& patches);

  int count() const { return static_cast<int>(patches_.size()); }
  Eigen::RowVector3d CentreOf(int patch, const PointsX3& pose) const;

  struct Goal {
    int patch = 0;
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
  };
  /// @param goals  of different patches
  /// @return the largest displacement of a vertex
  double Apply(const std::vector<Goal>& goals, PointsX3& pose) const;

 private:
  std::vector<std::vector<int>> patches_;
  Eigen::MatrixXd columns_;     // V x P
  Eigen::MatrixXd compliance_;  // P x P
};

}  // namespace keypose::motion
