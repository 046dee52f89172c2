// Connected pieces of a surface: which belong to the object, and which are bits to drop.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::cleanup {

struct Piece {
  int faces = 0;
  double area = 0;
  double volume = 0;  ///< signed; meaningful for closed pieces
};

/// Pieces connected over shared vertices, in the order of their first face.
struct Pieces {
  std::vector<int> of_face;  ///< F, index into `list`
  std::vector<Piece> list;
};
Pieces FindPieces(const Mesh& mesh);

/// The faces whose piece is marked, with the vertices they use, in their order.
Mesh KeptPieces(const Mesh& mesh, const Pieces& pieces, const std::vector<char>& keep);

/// The mesh without pieces of less than `min_share` of the largest piece's area.
/// @param removed  receives the number of pieces dropped, added to what it holds
Mesh WithoutBits(const Mesh& mesh, double min_share, int* removed);

/// The largest piece by area together with all that come within `gap` of it, directly or over
/// others; the rest is dropped.
Mesh WithTouchingPieces(const Mesh& mesh, double gap, int* removed);

/// The `count` pieces that enclose most volume, by size; 0 keeps all.
Mesh LargestPieces(const Mesh& closed, int count, int* removed);

/// Each piece turned so that it encloses a positive volume.
void OrientOutward(Mesh& closed);

}  // namespace keypose::cleanup
