// Patches of a surface that are held at given places, by multipliers.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "core/values/mesh.h"
#include "deform/poisson/poisson.h"

namespace keypose::motion {

/// Where a vertex of a pose is.
using PointOf = std::function<Eigen::RowVector3d(int vertex)>;

/// What a patch's hold moves, and which point of it is held.
struct HeldPatch {
  std::vector<int> vertices;                   ///< not empty; pulled alike
  std::vector<std::pair<int, double>> centre;  ///< the point: vertices and weights that sum to 1
};

/// The patch whose point is the mean of its vertices.
HeldPatch PatchOf(std::vector<int> vertices);

/// The smoothest local displacements that bring points of patches exactly to given places.
///
/// A displacement minimises |grad|^2 + kappa |.|^2, the screened energy of PoissonSystem, pulled by
/// forces on the patches' vertices. The factor is that of the system, and one column for each patch
/// is solved once; a pose then costs a dense system with one unknown for each patch that is held.
/// Nothing is factored again.
/// Source: Lagrange multipliers by the Schur complement.
class HeldPatches {
 public:
  /// @param system  built with screening; only used here
  HeldPatches(const PoissonSystem& system, const std::vector<HeldPatch>& patches);

  int count() const { return static_cast<int>(patches_.size()); }
  Eigen::RowVector3d CentreOf(int patch, const PointOf& point_of) const;
  const HeldPatch& patch(int patch) const { return patches_[patch]; }

  struct Goal {
    int patch = 0;
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
  };
  /// V x P: what a unit pull on each patch does to each vertex.
  const Eigen::MatrixXd& columns() const { return columns_; }
  /// G x G: what a unit pull on the patch of goal b does to the point of the patch of goal a.
  /// @param goals  of different patches
  Eigen::MatrixXd Compliance(const std::vector<Goal>& goals) const;

 private:
  std::vector<HeldPatch> patches_;
  Eigen::MatrixXd columns_, compliance_;  // compliance: P x P
};

}  // namespace keypose::motion
