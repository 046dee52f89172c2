// Seams: edges where the vertices are doubled because each side has its own texture coordinates.
// The surface itself is not cut there.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Which vertices are the same point of the surface.
struct Seams {
  std::vector<int> one;  ///< V: for each vertex the first vertex that it is joined to, or itself;
                         ///< empty without seams
  int joined = 0;        ///< number of vertices that are joined to an earlier one
  bool empty() const { return joined == 0; }
};

/// Finds the vertices that are doubled at seams.
///
/// Two edges are the two sides of a seam when each bounds one face, their ends have exactly the
/// same two positions in opposite order, and no third edge has these positions. Then their ends are
/// joined. Parts that touch in one point, or back to back, are not joined.
/// Cost: one sort for a mesh without repeated positions. Deterministic.
Seams FindSeams(const Mesh& mesh);

/// The faces, with each vertex replaced by the one it is joined to. Vertices keep their numbers;
/// doubles become unused.
FacesX3 WeldedFaces(const FacesX3& faces, const Seams& seams);

/// A mesh whose seams were closed.
struct WeldedMesh {
  Mesh mesh;  ///< points and faces only, in the input's order; faces that became an edge are left
              ///< out
  std::vector<int> of_input;  ///< the welded vertex of each input vertex
};
WeldedMesh Weld(const Mesh& mesh, const Seams& seams);
/// The mesh with all its seams closed, for moving it as one surface. Faces keep their numbers:
/// where one would become an edge, nothing is joined.
WeldedMesh WeldWholeFaces(const Mesh& mesh);

}  // namespace keypose
