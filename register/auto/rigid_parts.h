// The parts of a figure that moved as rigid bodies between two poses: first the one that did not
// change, then limbs that turned.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A part of a source that one similarity lays onto the target.
struct RigidPart {
  Similarity3 target_from_source;
  std::vector<int> held;  ///< vertices that lie on the target with all their neighbours, ascending
  PointsX3 feet;          ///< one for each of `held`: its nearest point on the target
  double share = 0;       ///< of the source's area that lies on the target
};

/// Finds the parts that moved as rigid bodies, by robust ICP (point to plane, from wide to narrow
/// distances), from a bent result and from turns of it. The first part has at least half of the
/// area; a smooth figure that bends can slide as a whole, since bending everything a little costs
/// less than bending one limb far, and that part shows it. Further parts have at least a third of
/// what is left and the same scale.
///
/// None is returned where no part is that large, where it could slide over itself (a ball, a
/// cylinder), and where two different places fit nearly alike.
/// @param source  V vertices, without seams
/// @param bent    V x 3, a registration of the source onto the target
/// Deterministic; same bits for any thread count.
std::vector<RigidPart> FindRigidParts(const Mesh& source, const Mesh& target, const PointsX3& bent);

/// The share of the part's vertices that `bent` leaves where the part's similarity puts them,
/// within 0.5 % of the target's diagonal.
double ShareInPlace(const RigidPart& part, const Mesh& source, const PointsX3& bent,
                    double target_diagonal);

/// Whether a landmark within a part wants to be elsewhere, by more than 1 % of the target's
/// diagonal.
/// @param points  V x 3, the source
bool Contradict(const std::vector<LandmarkGoal>& landmarks, const std::vector<RigidPart>& parts,
                const PointsX3& points, double target_diagonal);

/// Adds landmarks that hold the parts where they lie, at most 60 a part, evenly by number.
void AddPins(const std::vector<RigidPart>& parts, std::vector<LandmarkGoal>& goals);

/// V factors on the shape term, large where parts are held, but below that of a rigid piece.
/// @param stiffness  V, or empty: all 1
Eigen::VectorXd Stiffened(const Eigen::VectorXd& stiffness, Eigen::Index vertices,
                          const std::vector<RigidPart>& parts);

}  // namespace keypose::registration
