// Animated meshes as binary glTF 2.0.
#pragma once

#include <string>
#include <vector>

#include "export/animated_mesh.h"
#include "export/playback.h"
#include "export/texture_blend.h"

namespace keypose::exporting {

/// A compressed image as its file holds it.
struct EncodedImage {
  std::string bytes;      ///< empty: no texture
  std::string mime_type;  ///< "image/png" or "image/jpeg"
  std::string name;
};

/// The textures of the poses, all in the mesh's one layout.
struct GlbTextures {
  /// the first is the base colour, which every viewer shows; empty: no texture
  std::vector<EncodedImage> images;
  std::vector<std::string> poses;  ///< whose texture each image is
  /// what a viewer blends that knows how; empty: the base colour throughout
  std::vector<TextureMoment> moments;
};

struct GlbOptions {
  PlaybackOptions playback;
  bool z_up = true;  ///< the frames' up is +z, as in Keypose's world; glTF's is +y: (x, y, z) ->
                     ///< (x, z, -y). False: +y already
  std::string name = "character";
};

/// The bytes of a GLB file: one mesh (the first frame), one morph target with positions and normals
/// for each other picture, named after the first frame that shows it (`frame_0001` and on), the
/// textures, and an animation of the targets' weights: linear where pictures blend, with a second
/// keyframe right before each step; a sampler of kind STEP where all are steps. One picture gives a
/// mesh without targets and animation. Several textures are named in the material's
/// `extras.keypose` (docs/file-formats.md).
///
/// @param frame_names  one a frame
/// @param clip         of the mesh's frames
/// @throws InputError  a texture for a mesh without texture coordinates, or more than the 4 GiB
/// that a GLB can hold The size is about 24 bytes a vertex and picture.
/// Source: glTF 2.0 specification, Khronos 2021.
std::string MakeGlb(const AnimatedMesh& mesh, const Clip& clip,
                    const std::vector<std::string>& frame_names, const GlbTextures& textures,
                    const GlbOptions& options);

}  // namespace keypose::exporting
