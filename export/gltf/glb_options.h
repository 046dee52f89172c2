// What the writers of GLB files share: textures and options.
#pragma once

#include <string>
#include <vector>

#include "export/animation/scene.h"

namespace keypose::exporting {

/// The textures of the poses, all in the layout of the mesh.
struct GlbTextures {
  /// the first is the base colour, which every viewer shows; empty: no texture
  std::vector<EncodedImage> images;
  std::vector<std::string> poses;  ///< the pose of each image
  /// for viewers that can blend textures; empty: always the base colour
  std::vector<TextureMoment> moments;
};

struct GlbOptions {
  PlaybackOptions playback;
  /// true: up is +z in the frames, as in Keypose's world, and is converted to glTF's +y: (x, y, z)
  /// -> (x, z, -y); false: up is already +y
  bool z_up = true;
  std::string name = "character";
};

}  // namespace keypose::exporting
