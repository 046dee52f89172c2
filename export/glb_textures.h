// The textures of a GLB: all as they are, or the light ones of a file that phones load.
#pragma once

#include <filesystem>
#include <string>

#include "export/gltf/glb_options.h"

namespace keypose::exporting {

/// @param of_poses  what the GLB has of the textures after the first, which only viewers blend that
/// know Keypose's note: "jpeg", "png" (as they are) or "none"
/// @param scratch   a folder for files that are not kept
GlbTextures FullTextures(const Scene& scene, const std::string& of_poses,
                         const std::filesystem::path& scratch);

struct LightTextures {
  GlbTextures textures;
  int width = 0, height = 0;  ///< of the first texture, px; 0: there is none
  /// of the first texture against the one it was made from, at that one's size; infinite: the same
  double psnr_db = 0;
};

/// The same, each at most `largest` px wide and high, and as JPEG of quality 85 unless it is
/// smaller as it is. JPEG and PNG are the formats that glTF 2.0 has without an extension; alpha,
/// which JPEG lacks, does not show: the material is opaque.
///
/// @param largest  >= 1
LightTextures MakeLightTextures(const Scene& scene, const std::string& of_poses, int largest,
                                const std::filesystem::path& scratch);

}  // namespace keypose::exporting
