// Reads the data for the page's player: the animation's frames and textures, or the template's
// mesh.
#pragma once

#include <optional>
#include <vector>

#include "report/evidence/contents.h"
#include "report/page/pictures.h"

namespace keypose::report {

/// Textures of the poses in the layout of `mesh`. If `mesh` has no UVs, they are taken from the
/// template. Empty if a texture is missing; only one if all poses share it.
std::vector<Image8> TexturesOf(const RunRecord& run, const std::vector<std::string>& poses,
                               Mesh& mesh);

/// The animation, else the template in its pose; nothing if there is neither.
/// @throws InputError, DiskError  as thrown by the readers of meshes and pictures
std::optional<PlayerPart> GatherPlayer(const Contents& contents, const Encoder& encode,
                                       const SidesOptions& sides);

}  // namespace keypose::report
