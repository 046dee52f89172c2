#include "core/surfaces/face_pairs.h"

#include <algorithm>
#include <array>

#include "core/values/size_of.h"

namespace keypose {
namespace {

struct HalfEdge {
  int low, high, face;
  bool forward;  // from low to high
  bool operator<(const HalfEdge& other) const {
    return std::array{low, high, face} < std::array{other.low, other.high, other.face};
  }
};

std::vector<HalfEdge> SortedHalfEdges(const FacesX3& faces) {
  std::vector<HalfEdge> edges;
  edges.reserve(3 * faces.rows());
  for (int f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = faces(f, k), b = faces(f, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), f, a < b});
    }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

FacePairs FindFacePairs(const FacesX3& faces) {
  const std::vector<HalfEdge> edges = SortedHalfEdges(faces);
  FacePairs result;
  for (int i = 0; i < SizeOf(edges);) {
    int end = i + 1;
    while (end < SizeOf(edges) && edges[end].low == edges[i].low &&
           edges[end].high == edges[i].high)
      ++end;
    if (end == i + 2 && edges[i].forward != edges[i + 1].forward) {
      const HalfEdge &left = edges[i].forward ? edges[i] : edges[i + 1],
                     &right = edges[i].forward ? edges[i + 1] : edges[i];
      result.pairs.push_back({left.low, left.high, left.face, right.face});
    }
    i = end;
  }
  return result;
}

}  // namespace keypose
