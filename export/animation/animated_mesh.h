// The frames of an animation as one mesh, with one vertex per corner that a renderer must
// distinguish. (Folder export/ has namespace exporting, since `export` is a C++ keyword.)
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::exporting {

/// One connectivity, many positions. Vertices are split along texture seams; normals are not, so
/// that seams are invisible.
struct AnimatedMesh {
  FacesX3 faces;                   ///< F x 3 into the split vertices
  UvsX2 uvs;                       ///< V x 2, v up, or empty
  std::vector<PointsX3> points;    ///< V x 3 per frame
  std::vector<PointsX3> normals;   ///< V x 3 per frame, unit length
  std::vector<int> source_vertex;  ///< V; the vertex of the input frames
};

/// @param frames  at least one; all with the faces of the first, whose UVs are used
/// @param names   names of the frames, for messages
/// @throws InputError  no frames, an unusable mesh, or a frame whose vertices or faces differ from
/// the first; names the frame and the place
AnimatedMesh MakeAnimatedMesh(const std::vector<Mesh>& frames,
                              const std::vector<std::string>& names);

}  // namespace keypose::exporting
