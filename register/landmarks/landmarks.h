// Checks picked landmark pairs and converts them to goals for registration.
#pragma once

#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A pick on a face of the source and one on a face of the target.
struct PickedPair {
  std::string name;
  int source_face = -1, target_face = -1;
  Eigen::Vector3d source_barycentric = Eigen::Vector3d::Zero(),
                  target_barycentric = Eigen::Vector3d::Zero();
};

struct CheckedLandmarks {
  std::vector<LandmarkGoal> goals;
  int duplicates = 0;     ///< pairs dropped because they repeat another pair
  bool coplanar = false;  ///< three or more, all nearly in one plane; they flatten the result
  std::vector<std::string> warnings;  ///< about landmarks that look wrong; see landmark_doubts.h
};

/// Checks the pairs against both meshes.
/// @throws InputError  names the landmarks, when
///                     - the mesh does not have the face,
///                     - barycentric coordinates are not finite, do not sum to 1 or are outside of
///                       the triangle, or
///                     - two pairs contradict each other: the same point of one mesh (within 1e-6
///                       of the diagonal) is paired with points of the other that are more than
///                       2 % of its diagonal apart
CheckedLandmarks CheckLandmarks(const std::vector<PickedPair>& pairs, const Mesh& source,
                                const Mesh& target);

}  // namespace keypose::registration
