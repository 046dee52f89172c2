// Animated meshes as binary glTF 2.0.
#pragma once

#include <string>
#include <vector>

#include "export/animated_mesh.h"
#include "export/playback.h"

namespace keypose::exporting {

/// A compressed image as its file holds it.
struct EncodedImage {
  std::string bytes;      ///< empty: no texture
  std::string mime_type;  ///< "image/png" or "image/jpeg"
  std::string name;
};

struct GlbOptions {
  PlaybackOptions playback;
  bool z_up = true;  ///< the frames' up is +z, as in Keypose's world; glTF's is +y: (x, y, z) -> (x, z, -y). False: +y already
  std::string name = "character";
};

/// The bytes of a GLB file: one mesh (the first frame), one morph target with positions and normals for each other frame, named
/// `frame_0001` and on, the texture, and an animation of the targets' weights. One frame gives a mesh without targets and animation.
///
/// @param frame_names  one a frame; they become the names of the morph targets
/// @throws InputError  a texture for a mesh without texture coordinates, or more than the 4 GiB that a GLB can hold
/// The size is about 24 bytes a vertex and frame. Source: glTF 2.0 specification, Khronos 2021.
std::string MakeGlb(const AnimatedMesh& mesh, const std::vector<std::string>& frame_names, const EncodedImage& texture,
                    const GlbOptions& options);

}  // namespace keypose::exporting
