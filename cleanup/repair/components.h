// Connected pieces of a surface, and the selection of those that belong to the object.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::cleanup {

struct Piece {
  int faces = 0;
  double area = 0;
  double volume = 0;  ///< signed; meaningful for closed pieces
};

/// Pieces of faces connected by shared vertices, in the order of their first face.
struct Pieces {
  std::vector<int> of_face;  ///< F, index into `list`
  std::vector<Piece> list;
};
Pieces FindPieces(const Mesh& mesh);

/// The faces whose piece is marked, and their vertices, in the same order as before.
Mesh KeptPieces(const Mesh& mesh, const Pieces& pieces, const std::vector<char>& keep);

/// The mesh without pieces whose area is less than `min_share` of the largest piece's.
/// @param removed  increased by the number of removed pieces
Mesh WithoutBits(const Mesh& mesh, double min_share, int* removed);

/// The piece with the largest area, and all pieces within a distance of `gap` of it, directly or
/// through other pieces. The rest is removed.
Mesh WithTouchingPieces(const Mesh& mesh, double gap, int* removed);

/// The `count` pieces that enclose the most volume, the largest first. 0 keeps all.
Mesh LargestPieces(const Mesh& closed, int count, int* removed);

/// Orients each piece so that it encloses a positive volume.
void OrientOutward(Mesh& closed);

}  // namespace keypose::cleanup
