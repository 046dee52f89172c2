// Positions of a mesh and poses of the cameras that see it, solved for together.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/landmark_goal.h"
#include "deform/arap/arap_fit.h"
#include "fit/bending/view_constraints.h"

namespace keypose::fit {

/// A constraint on a level of the mesh: its vertex, and the arm as it stands now.
struct LevelConstraint {
  int view = 0;                                   ///< of `poses`; below 0: of none, left out here
  int vertex = 0;                                 ///< of the level
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();  ///< from the vertex, turned by its map
  Eigen::Matrix3d q = Eigen::Matrix3d::Zero();
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
};

/// One Gauss-Newton step on positions and poses at once. Alternating between the two would need
/// hundreds of steps: a camera that is a little wrong is balanced by a bent shape.
///
/// @param pulls     further pulls that do not depend on cameras
/// @param holding   weight of a camera's present pose, relative to its constraints' weight
/// @param poses     camera from world; moved
/// @return positions, V x 3
/// @throws SolverError
/// Cost: one sparse factorisation of 3 V + 6 C unknowns.
PointsX3 SolveJointly(const ArapFit& fit, const PointsX3& now,
                      const std::vector<LevelConstraint>& constraints, const Pulls& pulls,
                      double holding, std::vector<Rigid3>& poses);

}  // namespace keypose::fit
