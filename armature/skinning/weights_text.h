// Skin weights that another program made.
#pragma once

#include <string>
#include <vector>

#include "armature/skinning/skin.h"

namespace keypose::armature {

/// JSON {"weights": {"NAME": [[vertex, weight], ...], ...}}, as MakeHuman's .mhw, or libigl's .dmat
/// (ASCII: the numbers of columns and rows, then column after column).
///
/// @param names    of the joints whose turning moves the vertices; the columns of a .dmat are in
///                 their order
/// @param bone_of  the bone of each name; several may have the same
/// @param file   its name, for messages
/// @throws InputError  malformed, a bone that is not there, a vertex that the mesh does not have, a
/// vertex that no bone moves; names file and place
SkinWeights ParseWeights(const std::string& text, const std::string& file,
                         const std::vector<std::string>& names, const std::vector<int>& bone_of,
                         int vertex_count);

}  // namespace keypose::armature
