// The mesh that a point cache is bound to.
#pragma once

#include <string>
#include <vector>

#include "export/animation/scene.h"

namespace keypose::exporting {

/// Vertices that belong to a face, ascending. Blender's importer leaves out all others, and then a
/// cache with them would not fit.
std::vector<int> VerticesWithFace(const Mesh& mesh);

/// `PATH.obj` and `PATH.mtl`: one frame with +y up, its vertices with a face, not split and in
/// their order, its faces or polygons, and its texture coordinates if it has any. The material
/// shows the scene's first texture, `textures/texture_0.png`, by a path relative to the folder of
/// `path`, which is one folder deep. Numbers have the shortest form that gives back the same value
/// in single precision.
std::vector<FormatFile> MakeTemplateObj(const Scene& scene, const std::string& path, int frame);

}  // namespace keypose::exporting
