// Seams: places where a surface is cut only on paper, because both sides of the cut carry their own
// texture coordinates.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::registration {

/// Which vertices are one point of the surface.
struct Seams {
  std::vector<int> one;  ///< for each vertex the first one at its place that it is joined to,
                         ///< itself where there is none; empty: no seams
  int joined = 0;        ///< vertices that are joined to an earlier one
  bool empty() const { return joined == 0; }
};

/// Finds the vertices that a seam doubled.
///
/// Two edges are the two sides of a seam when each bounds one face, their ends lie at exactly the
/// same two places in opposite order, and no third edge does so. Their ends are one. Parts that
/// touch in a point, or back to back, stay apart, and so does a mesh without repeated places, which
/// costs one sort. Deterministic.
Seams FindSeams(const Mesh& mesh);

/// The faces with the first vertex at each place; vertices keep their numbers, doubles become
/// unused.
FacesX3 WeldedFaces(const FacesX3& faces, const Seams& seams);

/// A mesh without its seams.
struct WeldedMesh {
  Mesh mesh;  ///< points and faces only, in the order of the input; faces that shrank to an edge
              ///< are left out
  std::vector<int> of_input;  ///< the welded vertex of each input vertex
};
WeldedMesh Weld(const Mesh& mesh, const Seams& seams);

}  // namespace keypose::registration
