// Skin weights that another program made.
#pragma once

#include <string>
#include <vector>

#include "armature/skinning/skin.h"

namespace keypose::armature {

/// The formats of ParseBoneWeights (core/io/meshes/bone_weights.h).
///
/// @param names    of the joints whose turning moves the vertices; the columns of a .dmat are in
///                 their order
/// @param bone_of  the bone of each name; several may have the same
/// @param file   its name, for messages
/// @throws InputError  as ParseBoneWeights, and a vertex that no bone moves
SkinWeights ParseWeights(const std::string& text, const std::string& file,
                         const std::vector<std::string>& names, const std::vector<int>& bone_of,
                         int vertex_count);

}  // namespace keypose::armature
