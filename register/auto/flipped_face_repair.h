// Faces that came to rest on the opposite wall of a crease go back to their own.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"

namespace keypose::registration {

/// A mesh bent onto a target, as the last fit left it. Lengths are for a target of diagonal 2.
struct BentMesh {
  const PointsX3& rest;  ///< V x 3
  const FacesX3& faces;
  const PointsX3& moved;                     ///< V x 3
  const std::vector<Eigen::Matrix3d>& maps;  ///< V, from rest to moved
  double rigidity, smoothing;                ///< of the shape, see ArapFit
  double surface_weight;                     ///< of the whole surface, in units of the shape term
};

struct FlippedFaceRepair {
  PointsX3 points;  ///< V x 3
  /// faces whose normal points away from that of the target face with the nearest centre
  int before = 0;
  int after = 0;
};

/// Where the walls of a crease are closer together than the surface is exact, a face can lie nearer
/// to the opposite wall than to its own. Such faces, with three rings of vertices around them, are
/// bent again as elastic patches held at their rims: first without the surface, which lets folds
/// open; then each is pushed across the plane half way between the centre of the target face that
/// it wrongly lies at and that of the one of its own direction that takes the least way, if that is
/// under 0.2 % of the diagonal. A patch takes the round with the fewest faces that oppose the
/// target or have turned over, the first of these, so it never gets worse; nothing else moves.
///
/// @throws SolverError
/// Cost: one search for each face, then linear in the size of the patches.
/// Same bits for any thread count.
FlippedFaceRepair RepairFlippedFaces(const BentMesh& bent, const PointsX3& target_points,
                                     const FacesX3& target_faces);

}  // namespace keypose::registration
