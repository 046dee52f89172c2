// The mesh that a point cache is bound to.
#pragma once

#include <string>
#include <vector>

#include "export/animation/scene.h"

namespace keypose::exporting {

/// Vertices that belong to a face, in the order in which the written faces first have them. By
/// default Blender's importer for OBJ files (of 3.4) numbers vertices in this order, and leaves out
/// all others: a cache in another order would shred the figure.
std::vector<int> VerticesByFaces(const Scene& scene);

/// `PATH.obj` and `PATH.mtl`: one frame with +y up, its vertices with a face, not split and as
/// VerticesByFaces orders them, its faces or polygons, and its texture coordinates if it has any.
/// The material shows the scene's first texture, `textures/texture_0.png`, by a path relative to
/// the folder of `path`, which is one folder deep. Numbers have the shortest form that gives back
/// the same value in single precision.
std::vector<FormatFile> MakeTemplateObj(const Scene& scene, const std::string& path, int frame);

}  // namespace keypose::exporting
