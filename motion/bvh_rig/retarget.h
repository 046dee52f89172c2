// A motion clip on a rig of other proportions.
#pragma once

#include <vector>

#include "core/values/motion_clip.h"
#include "motion/bvh_rig/rigged_mesh.h"

namespace keypose::motion {

/// Which axis points up, by the legs at rest.
struct RestUp {
  bool has_legs = false;
  bool upright = false;  ///< the legs hang along y or z
  int axis = 1;          ///< 1, 2: y or z; y where legs do not tell
};
struct RestUps {
  RestUp clip, rig;
};
/// @param joints  of each bone, from MatchJoints
RestUps UpsAtRest(const MotionClip& clip, const RiggedMesh& rig, const std::vector<int>& joints);

/// Whether the first frame is the clip's rest pose, and the second one is not: recorded clips often
/// have such a frame in front, which does not belong to the motion.
bool BeginsWithItsRest(const MotionClip& clip);

/// 1, 2: y or z is up.
struct UpAxes {
  int clip = 1, rig = 1;
};

/// Poses a rig after a clip.
///
/// A bone's turn is that of its joint since the clip's rest pose (all angles zero), in the world.
/// An upper or lower arm or leg first takes the clip's own direction at rest by the shortest turn,
/// so that a rig bound with hanging arms takes clips that start with level ones. Bones without a
/// joint turn with their parents. The root's path is scaled by the ratio of the legs' lengths. The
/// clip is first turned about the vertical so that its thighs lie as the rig's.
class Retarget {
 public:
  /// @param joints  of each bone, from MatchJoints
  Retarget(const MotionClip& clip, const RiggedMesh& rig, const std::vector<int>& joints,
           UpAxes up);

  /// @param frame  of the clip; between two frames, between their poses
  /// @pre 0 <= frame <= clip.frame_count() - 1
  std::vector<BoneMove> At(double frame) const;
  double scale() const { return scale_; }

 private:
  const MotionClip& clip_;
  const RiggedMesh& rig_;
  std::vector<int> joints_;
  Eigen::Matrix3d rig_from_clip_ = Eigen::Matrix3d::Identity();
  std::vector<Eigen::Matrix3d> to_clip_rest_;  // of each bone
  double scale_ = 1;
  int root_joint_ = 0;
  int root_bone_ = 0;
  Eigen::Vector3d clip_rest_;  // of the root joint
};

}  // namespace keypose::motion
