// The frames of an animation as one mesh with a vertex for each corner that a renderer must tell
// apart. (Folder export/ has namespace exporting: the word is a C++ keyword.)
#pragma once

#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::exporting {

/// One connectivity, many positions. Vertices are split along texture seams, normals are not: seams
/// do not show.
struct AnimatedMesh {
  FacesX3 faces;                   ///< F x 3 into the split vertices
  UvsX2 uvs;                       ///< V x 2, v up, or empty
  std::vector<PointsX3> points;    ///< one V x 3 a frame
  std::vector<PointsX3> normals;   ///< one V x 3 a frame, unit
  std::vector<int> source_vertex;  ///< V, the vertex of the frames that each came from
};

/// @param frames  at least one; all with the faces of the first; UVs are taken from the first
/// @param names   of the frames, for messages
/// @throws InputError  no frames, an unusable mesh, or a frame with other vertices or faces than
/// the first; names the frame and the place
AnimatedMesh MakeAnimatedMesh(const std::vector<Mesh>& frames,
                              const std::vector<std::string>& names);

}  // namespace keypose::exporting
