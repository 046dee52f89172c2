// Faces by the vertices that they lie around.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

/// The faces at some vertices. A fan is a vertex, its centre, and a chain of neighbours: a face is
/// the centre and two that follow each other. Chains of one fan are joined by the centre itself,
/// which makes faces without area. So each point of a fan is read once, not once a face.
struct FaceFans {
  std::vector<int> centre;    ///< of each fan
  std::vector<int> begin{0};  ///< fans + 1
  std::vector<int> chain;

  int count() const { return static_cast<int>(centre.size()); }
};

/// Each face in the fan of each of its corners that is listed, in the order of `vertices`.
FaceFans FansOfVertices(const FacesX3& faces, int vertex_count, const std::vector<int>& vertices);
/// Each face that has a listed corner in one fan, in few and long chains.
/// @param vertices  all of a face, or none
FaceFans FansOfFaces(const FacesX3& faces, int vertex_count, const std::vector<int>& vertices);

}  // namespace keypose::motion
