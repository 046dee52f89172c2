// The fixed sparsity pattern of the non-rigid ICP normal matrix, and the positions (slots) of its
// values.
#pragma once

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose {

/// Lower triangle, column-compressed, 4V x 4V. Diagonal blocks are dense (10 values); an edge's
/// block holds its diagonal (4 values), or all 16 where a landmark mixes both vertices.
struct SparsePattern {
  int vertex_count = 0;
  std::vector<std::pair<int, int>> edges;  ///< i < j, sorted
  std::vector<char> edge_full;             ///< 1 where the block holds all 16 values
  std::vector<int> columns, rows;          ///< 4V+1, nonzeros
  /// first value (the diagonal) in each of the vertex's 4 columns
  std::vector<std::array<int, 4>> vertex_slot;
  /// first value of the edge's block in each of vertex i's 4 columns
  std::vector<std::array<int, 4>> edge_slot;

  int nonzeros() const { return SizeOf(rows); }
  int EdgeIndex(int i, int j) const;  ///< i < j; -1 when there is no such edge
  /// Slot of the entry at row (vertex i, part r), column (vertex j, part c), or of its transpose in
  /// the lower triangle.
  int Slot(int i, int r, int j, int c) const;
};

/// @param mixed  pairs of vertices (in any order) that a landmark mixes; they become edges of the
/// result even if no face has them
SparsePattern MakeSparsePattern(int vertex_count, const FacesX3& faces,
                                const std::vector<std::pair<int, int>>& mixed);

/// The connected component of each vertex. Components are numbered in the order of their first
/// vertices; `count` receives their number.
std::vector<int> Components(int vertex_count, const std::vector<std::pair<int, int>>& edges,
                            int& count);

}  // namespace keypose
