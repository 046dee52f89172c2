// Fills a closed surface with tetrahedra whose boundary is that surface.
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::interpolation {

using TetsX4 = Eigen::Matrix<int, Eigen::Dynamic, 4,
                             Eigen::RowMajor>;  ///< rows are 0-based corners of positive volume

struct TetrahedralizeOptions {
  /// wanted edge length of inner tetrahedra over each body's mean surface edge, > 0
  double element_size = 1;
  /// approximate; inner tetrahedra become larger where element_size would need more
  int max_tetrahedra = 50000;
  /// Where a body intersects itself, smooths the crossing away first and fills the result;
  /// Solid::points then differ from the surface there.
  bool part_crossings = false;
};

/// A solid: one or several bodies that share no vertex.
struct Solid {
  PointsX3 points;  ///< N x 3; the first V rows are the surface's vertices, bit for bit (but see
                    ///< `parted`)
  TetsX4 tets;      ///< T x 4, body after body
  /// T; the tetrahedron behind the face opposite each corner, or -1
  std::vector<std::array<int, 4>> opposite;
  std::vector<int> body_of_point;  ///< N; -1 for vertices that no face uses
  std::vector<int> body_of_face;   ///< F
  int bodies = 0;
  int parted = 0;  ///< vertices of the surface that were moved to remove crossings
};

/// Bodies are connected parts; a part that faces inwards is a hollow of the smallest body around
/// it. Each body is filled by itself, so bodies may overlap (eyeballs), but a body must not touch
/// itself. Deterministic.
/// Cost: near linear; 3,500 faces 0.1 s.
///
/// @throws InputError  zero-area face, edge without exactly two faces, inside-out or self-touching
/// surface; names `what`, place and remedy
/// Source: TetGen, H. Si, ACM TOMS 41(2), 2015; options pYMq1.4/0a.
Solid Tetrahedralize(const PointsX3& points, const FacesX3& faces, const std::string& what,
                     const TetrahedralizeOptions& options = {});

}  // namespace keypose::interpolation
