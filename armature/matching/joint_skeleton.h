// The computer's skeleton: a tree of named joints, each of which can turn about all axes.
#pragma once

#include <string>
#include <vector>

#include "armature/description/armature.h"
#include "core/values/camera.h"
#include "core/values/mesh.h"
#include "core/values/motion_clip.h"

namespace keypose::armature {

struct SkeletonJoint {
  std::string name;
  int parent = -1;                                 ///< index of an earlier joint; -1: a root
  Eigen::Vector3d rest = Eigen::Vector3d::Zero();  ///< where it is when the mesh is at rest
};

/// Bone j leads from the parent of joint j to joint j; roots have none.
struct Skeleton {
  std::vector<SkeletonJoint> joints;

  int size() const { return static_cast<int>(joints.size()); }
  /// The joint of that name, or -1.
  int Find(const std::string& name) const;
  /// Joints from one to another along the tree, both included; empty if they stand in different
  /// trees.
  std::vector<int> PathBetween(int from, int to) const;
};

/// A skeleton at a moment.
struct SkeletonPose {
  /// of bone j: x_now = bones[j] * x_at_rest. That of a root moves what hangs on the root itself.
  std::vector<Rigid3> bones;
  PointsX3 joints;  ///< J x 3
};

/// The joints of a motion clip, with all angles zero. Ends without a name get that of their parent
/// and "_end".
/// @param y_up  the clip has y up; the skeleton gets z up, and what looked along z looks along -y
/// @throws InputError  no joints, two of one name
Skeleton SkeletonOfClip(const MotionClip& clip, bool y_up);

/// A skeleton like the armature itself: a joint at each place of a chain, named by the last node
/// that stands there, or by the anchor's computer joint.
/// @param frames  of the armature's nodes in its zero position, in the skeleton's world
Skeleton SkeletonOfArmature(const Armature& armature, const ChainPlan& plan,
                            const std::vector<Rigid3>& frames);

}  // namespace keypose::armature
