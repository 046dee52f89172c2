// A mesh with what its file has and the mesh has not.
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

struct NotedMesh {
  Mesh mesh;
  std::vector<std::string> notes;  ///< parts of sentences, which follow the file's name
};

}  // namespace keypose
