// Checks picked landmark pairs and turns them into goals for registration.
#pragma once

#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"

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
  int duplicates = 0;     ///< pairs dropped since another says the same
  bool coplanar = false;  ///< three or more that lie nearly in a plane: they flatten the result
  std::vector<std::string> warnings;  ///< what looks wrong without being impossible, naming
                                      ///< landmarks; see landmark_doubts.h
};

/// @throws InputError  a face that the mesh does not have, coordinates not finite or not summing to
/// 1 or outside the triangle, or two pairs that
///                     contradict each other: the same point (within 1e-6 of the diagonal) of one
///                     mesh paired with points of the other that are more than 2 % of its diagonal
///                     apart; names the landmarks
CheckedLandmarks CheckLandmarks(const std::vector<PickedPair>& pairs, const Mesh& source,
                                const Mesh& target);

}  // namespace keypose::registration
