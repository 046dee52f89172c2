// The polygons that a mesh of triangles was made from.
#pragma once

#include <vector>

namespace keypose {

/// Polygons of three corners or more. One of n corners is the next n - 2 rows of the faces of its
/// mesh, so that the sizes alone say which triangles are whose.
struct Polygons {
  std::vector<int> sizes;    ///< corners of each polygon
  std::vector<int> corners;  ///< vertices, one polygon after the other, each from its first corner
};

}  // namespace keypose
