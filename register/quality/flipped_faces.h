// Which faces of a registered mesh face the wrong way.
#pragma once

#include <vector>

#include "core/kd_tree.h"
#include "core/mesh.h"

namespace keypose::registration {

/// F x 3.
PointsX3 FaceCentres(const PointsX3& points, const FacesX3& faces);

/// A target as a set of face centres, which is how a flipped face is told.
struct TargetFaces {
  /// @throws InputError  no faces
  TargetFaces(const PointsX3& points, const FacesX3& faces);

  /// 1 for each face whose normal points away (dot < 0) from that of the target face with the
  /// nearest centre.
  /// Same bits for any thread count.
  std::vector<char> Opposed(const PointsX3& points, const FacesX3& faces) const;

  PointsX3 centres, normals;  ///< of the target's faces
  KdTree tree;                ///< of the centres
};

}  // namespace keypose::registration
