// Faces of a registered mesh that are flipped.
#pragma once

#include <vector>

#include "core/numbers/kd_tree.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// The target as a set of face centres and normals, to find flipped faces.
struct TargetFaces {
  /// @throws InputError  no faces
  TargetFaces(const PointsX3& points, const FacesX3& faces);

  /// Finds faces whose normal opposes (dot < 0) the normals of all nearby target faces. Nearby are
  /// the target face with the nearest centre, and those at most `slack` farther.
  /// @param slack  >= 0 [length]; 0: the nearest face alone. In a narrow crease the nearest face
  ///               may belong to the opposite wall.
  /// @return one per face, 1 for a flipped face
  /// Same bits for any thread count.
  std::vector<char> Opposed(const PointsX3& points, const FacesX3& faces, double slack) const;

  PointsX3 centres, normals;  ///< of the target's faces
  KdTree tree;                ///< of the centres
};

}  // namespace keypose::registration
