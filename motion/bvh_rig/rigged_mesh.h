// A rigged mesh: bones, and how much each moves each vertex.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

struct Bone {
  std::string name;
  int parent = -1;  ///< index of an earlier bone; -1: a root
  Eigen::Vector3d head = Eigen::Vector3d::Zero(), tail = Eigen::Vector3d::Zero();  ///< when bound
};

struct RiggedMesh {
  Mesh mesh;                ///< in the pose in which it was bound to the bones
  std::vector<Bone> bones;  ///< parents before their children
  /// of each vertex: bone and weight; they sum to 1, or there are none
  std::vector<std::vector<std::pair<int, double>>> weights;

  /// The bone of that name, or -1.
  int Find(const std::string& name) const;
};

/// Where a bone is, against where it was bound.
struct BoneMove {
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  Eigen::Vector3d head = Eigen::Vector3d::Zero();  ///< where its head is now
};

/// Linear blend skinning. Vertices without weights move with the first bone.
/// @param moves  one for each bone
/// @return V x 3
PointsX3 Skinned(const RiggedMesh& rig, const std::vector<BoneMove>& moves);

/// The rig with only the largest connected part of its mesh; its vertices keep their order.
RiggedMesh LargestPart(const RiggedMesh& rig);

}  // namespace keypose::motion
