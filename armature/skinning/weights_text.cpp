#include "armature/skinning/weights_text.h"

#include <algorithm>

#include "core/io/meshes/bone_weights.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose::armature {

SkinWeights ParseWeights(const std::string& text, const std::string& file,
                         const std::vector<std::string>& names, const std::vector<int>& bone_of,
                         int vertex_count) {
  const BoneWeights read = ParseBoneWeights(text, "armature: " + file, names, vertex_count);
  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(vertex_count, SizeOf(names));
  for (int v = 0; v < vertex_count; ++v) {
    if (read[v].empty())
      throw InputError("armature: " + file + ": no bone moves vertex " + std::to_string(v) +
                       " of the mesh; give it a weight, or leave --weights out to have all weights "
                       "computed");
    for (const auto& [name, weight] : read[v]) dense(v, name) += weight;
  }
  const int bones = *std::max_element(bone_of.begin(), bone_of.end()) + 1;
  Eigen::MatrixXd of_bones = Eigen::MatrixXd::Zero(vertex_count, bones);
  for (int n = 0; n < SizeOf(names); ++n) of_bones.col(bone_of[n]) += dense.col(n);
  return Pruned(of_bones);
}

}  // namespace keypose::armature
