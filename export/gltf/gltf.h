// Animated meshes as binary glTF 2.0.
#pragma once

#include <string>
#include <vector>

#include "export/gltf/glb_options.h"

namespace keypose::exporting {

/// The bytes of a GLB file. It has one mesh (the first frame), the textures, and one morph target
/// with positions and normals per further picture, named after the first frame that shows it
/// (`frame_0001`, ...). An animation sets the targets' weights. It is linear where pictures blend,
/// with a second keyframe right before each step; if all changes are steps, the sampler is STEP. A
/// single picture gives a mesh without targets and animation. Several textures are listed in the
/// material's `extras.keypose` (docs/file-formats.md).
///
/// @param frame_names  one per frame
/// @param clip         the clip of the mesh's frames
/// @throws InputError  a texture for a mesh without texture coordinates, or more than the 4 GiB
/// that a GLB can hold. The size is about 24 bytes per vertex and picture. Source: glTF 2.0
/// specification, Khronos 2021.
std::string MakeGlb(const AnimatedMesh& mesh, const Clip& clip,
                    const std::vector<std::string>& frame_names, const GlbTextures& textures,
                    const GlbOptions& options);

/// Largest distance of a vertex between a frame and what a player makes of the single-precision
/// numbers of MakeGlb, in the unit of the frames.
double GlbError(const AnimatedMesh& mesh);

}  // namespace keypose::exporting
