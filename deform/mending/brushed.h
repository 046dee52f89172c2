// The part of a surface that lies under a stroke of the brush.
#pragma once

#include <vector>

#include "core/surfaces/mend_stroke.h"
#include "core/values/mesh.h"

namespace keypose {

/// The vertices next to each vertex, and the faces round it. Faces do not change while a mesh is
/// mended.
struct MeshRings {
  explicit MeshRings(const Mesh& mesh);
  std::vector<std::vector<int>> neighbours, faces;
};

/// Vertices under a stroke: those nearer to its path than the radius, and joined to it by such.
struct Brushed {
  std::vector<int> vertices;  ///< ascending
  /// Of each: 1 on the path, 0 at the radius.
  std::vector<double> weights;
  /// Of each: the mean direction of the surface round the nearest point of the path, unit.
  PointsX3 directions;
};

/// @param points  V x 3, where the vertices are by now
/// @throws InputError  a place on a face that the mesh does not have
Brushed UnderBrush(const Mesh& mesh, const MeshRings& rings, const PointsX3& points,
                   const MendStroke& stroke);

}  // namespace keypose
