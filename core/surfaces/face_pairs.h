// The edges of a mesh with the two faces at each: where outlines can run.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose {

struct FacePairs {
  struct Pair {
    int a, b;         ///< the edge's vertices, a < b
    int left, right;  ///< faces; left has the edge in the direction a to b
  };
  std::vector<Pair> pairs;  ///< sorted by vertices; edges without exactly two faces are left out
};
FacePairs FindFacePairs(const FacesX3& faces);

}  // namespace keypose
