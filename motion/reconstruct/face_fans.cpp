#include "motion/reconstruct/face_fans.h"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/values/size_of.h"

namespace keypose::motion {

namespace {

/// Sides of faces, each opposite a vertex.
using Sides = std::vector<std::pair<int, int>>;

/// The corners of each vertex: three times the face, and the corner's number.
struct Corners {
  Corners(const FacesX3& faces, int vertex_count) : begin(vertex_count + 1, 0) {
    for (Eigen::Index k = 0; k < faces.size(); ++k) ++begin[faces.data()[k] + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    corner.resize(faces.size());
    std::vector<int> at(begin.begin(), begin.end() - 1);
    for (int k = 0; k < static_cast<int>(faces.size()); ++k) corner[at[faces.data()[k]]++] = k;
  }
  std::vector<int> begin, corner;
};

/// The side that begins a chain: one that follows no other, where there is one.
Sides::iterator FirstOf(Sides& sides) {
  const auto follows_none = [&](const auto& side) {
    return std::none_of(sides.begin(), sides.end(),
                        [&](const auto& other) { return other.second == side.first; });
  };
  const auto found = std::find_if(sides.begin(), sides.end(), follows_none);
  return found == sides.end() ? sides.begin() : found;
}

void AppendFan(int centre, Sides sides, FaceFans& fans) {
  fans.centre.push_back(centre);
  while (!sides.empty()) {
    if (SizeOf(fans.chain) > fans.begin.back()) fans.chain.push_back(centre);
    auto side = FirstOf(sides);
    fans.chain.push_back(side->first);
    while (side != sides.end()) {
      const int end = side->second;
      fans.chain.push_back(end);
      sides.erase(side);
      side =
          std::find_if(sides.begin(), sides.end(), [&](const auto& s) { return s.first == end; });
    }
  }
  fans.begin.push_back(SizeOf(fans.chain));
}

/// The sides opposite the vertex of faces that are wanted.
Sides SidesOf(const FacesX3& faces, const Corners& corners, int vertex, const auto& wanted) {
  Sides sides;
  for (int at = corners.begin[vertex]; at < corners.begin[vertex + 1]; ++at) {
    const int face = corners.corner[at] / 3, k = corners.corner[at] % 3;
    if (wanted(face)) sides.emplace_back(faces(face, (k + 1) % 3), faces(face, (k + 2) % 3));
  }
  return sides;
}

}  // namespace

FaceFans FansOfVertices(const FacesX3& faces, int vertex_count, const std::vector<int>& vertices) {
  const Corners corners(faces, vertex_count);
  FaceFans fans;
  for (const int i : vertices)
    AppendFan(i, SidesOf(faces, corners, i, [](int) { return true; }), fans);
  return fans;
}

FaceFans FansOfFaces(const FacesX3& faces, int vertex_count, const std::vector<int>& vertices) {
  const Corners corners(faces, vertex_count);
  std::vector<int> owner(faces.rows(), -1);
  const auto own = [&](int i, bool only_if_all) {
    const auto begin = corners.corner.begin() + corners.begin[i],
               end = corners.corner.begin() + corners.begin[i + 1];
    const auto taken = [&](int corner) { return owner[corner / 3] >= 0; };
    if (only_if_all && std::any_of(begin, end, taken)) return;
    for (auto at = begin; at != end; ++at)
      if (!taken(*at)) owner[*at / 3] = i;
  };
  // Whole rings first: the longest chains.
  for (const bool only_if_all : {true, false})
    for (const int i : vertices) own(i, only_if_all);
  FaceFans fans;
  for (const int i : vertices) {
    Sides sides = SidesOf(faces, corners, i, [&](int face) { return owner[face] == i; });
    if (!sides.empty()) AppendFan(i, std::move(sides), fans);
  }
  return fans;
}

}  // namespace keypose::motion
