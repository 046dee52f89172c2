// The mesh whose vertices a vertex animation texture moves.
#pragma once

#include <string>

#include "export/animation/scene.h"
#include "export/vat/vat_layout.h"

namespace keypose::exporting {

/// A GLB without animation: one frame with split vertices, +y up, and the scene's first texture.
/// TEXCOORD_1 is the centre of the vertex's texel in the block of a frame: u = (column + 1/2) /
/// columns, v = (row + 1/2) / rows_per_frame. A second set of texture coordinates survives what
/// engines do to meshes when they import them; the order of vertices does not.
///
/// @throws InputError  a texture for a mesh without texture coordinates
/// Source: glTF 2.0 specification, Khronos 2021.
std::string MakeVatMesh(const Scene& scene, const VatLayout& layout, int frame);

}  // namespace keypose::exporting
