// Rigs from the texts of their files: MakeHuman's skeletons and weights, and libigl's.
#pragma once

#include <string>

#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion {

/// Joins a mesh with its skeleton and weights.
///
/// Skeletons: MakeHuman's .mhskel (JSON; a joint is the mean of some of the mesh's vertices), or
/// .tgf (lines `number x y z`, then `#`, then edges `from to`; each edge is a bone, named
/// "from-to"). Weights: the formats of ParseBoneWeights (core/io/meshes/bone_weights.h); the
/// columns of a .dmat are in the order of the .tgf's edges.
/// @param skeleton_name, weights_name  of the files, for messages
/// @throws InputError  malformed, an unknown bone or joint, a vertex that the mesh does not have,
/// bones that do not form a tree; names file and place
RiggedMesh MakeRig(Mesh mesh, const std::string& skeleton, const std::string& skeleton_name,
                   const std::string& weights, const std::string& weights_name);

}  // namespace keypose::motion
