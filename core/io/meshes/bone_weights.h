// Reads which bones move the vertices of a mesh, and how much, as other programs wrote it.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace keypose {

/// For each vertex: bones, as places in a list of names, with their weights, from 0 and not scaled.
using BoneWeights = std::vector<std::vector<std::pair<int, double>>>;

/// JSON {"weights": {"NAME": [[vertex, weight], ...], ...}}, as MakeHuman's .mhw, or libigl's .dmat
/// (ASCII: the numbers of columns and rows, then column after column; a column for each name, in
/// their order). Weights of 0, and down to -1e-6 by rounding, are left out.
///
/// @param file  its name, with the program's, for messages: "animate: hero.mhw"
/// @throws InputError  malformed, a bone that is not there, a vertex that the mesh does not have, a
/// weight that is negative or not finite; names file and place
BoneWeights ParseBoneWeights(const std::string& text, const std::string& file,
                             const std::vector<std::string>& names, int vertex_count);

}  // namespace keypose
