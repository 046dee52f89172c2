// The faces of a mesh as its author drew them: polygons with their vertices and texture corners.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "core/values/polygons.h"

namespace keypose {

struct FaceNet {
  std::vector<int> sizes;     ///< corners of each face
  std::vector<int> vertices;  ///< of all corners, one face after the other
  std::vector<int> uvs;  ///< of all corners, into the mesh's; empty without texture coordinates
  /// Polygons that are triangles here: a texture's seam runs through them, or a vertex comes twice.
  int taken_apart = 0;

  int face_count() const { return static_cast<int>(sizes.size()); }
};

/// Polygons keep their order, winding and first corner. Each must be what its triangles cover: all
/// its edges are theirs.
/// @param polygons  of the mesh; empty: the triangles are the faces
/// @throws InputError  they are not those of the mesh's triangles; says which
FaceNet NetOf(const Mesh& mesh, const Polygons& polygons);

}  // namespace keypose
