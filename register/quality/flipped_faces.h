// Which faces of a registered mesh face the wrong way.
#pragma once

#include <vector>

#include "core/kd_tree.h"
#include "core/mesh.h"

namespace keypose::registration {

/// A target as a set of face centres, which is how a flipped face is told.
struct TargetFaces {
  /// @throws InputError  no faces
  TargetFaces(const PointsX3& points, const FacesX3& faces);

  /// 1 for each face whose normal points away (dot < 0) from those of all target faces with
  /// centres at most `slack` farther from its own than the nearest.
  /// @param slack  >= 0 [length]; 0: the nearest alone; in a crease that is as narrow as the
  /// surfaces are exact, the nearest centre may be the opposite wall's Same bits for any thread
  /// count.
  std::vector<char> Opposed(const PointsX3& points, const FacesX3& faces, double slack) const;

  PointsX3 centres, normals;  ///< of the target's faces
  KdTree tree;                ///< of the centres
};

}  // namespace keypose::registration
