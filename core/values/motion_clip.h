// A skeleton and its motion, as BVH files hold them: a tree of joints with fixed offsets, and Euler
// angles for each frame.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// What one number of a frame moves.
enum class BvhChannel { kXposition, kYposition, kZposition, kXrotation, kYrotation, kZrotation };

struct ClipJoint {
  std::string name;                                  ///< "" for the end of a limb ("End Site")
  int parent = -1;                                   ///< index of an earlier joint; -1: the root
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();  ///< from the parent, in the parent's frame
  std::vector<BvhChannel> channels;  ///< in the order of the numbers; ends have none
};

/// A motion. Parents come before their children. Lengths are in the file's unit, angles in degrees,
/// as in the file; what is up is not known (mostly y).
struct MotionClip {
  std::vector<ClipJoint> joints;
  double frame_time_s = 1.0 / 30;
  /// one row a frame, one column a channel, joint after joint
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> values;

  int frame_count() const { return static_cast<int>(values.rows()); }
  int channel_count() const;
  /// The joint of that name, or -1.
  int Find(const std::string& name) const;
};

/// The frame of each joint in the clip's world: x_in_world = result[j] * x_in_joint.
/// @pre 0 <= frame < clip.frame_count()
std::vector<Rigid3> JointFrames(const MotionClip& clip, int frame);

/// Angles [rad] of the rotation Rz(z) Ry(y) Rx(x), each in [-pi, pi], y in [-pi/2, pi/2].
/// @return z, y, x
Eigen::Vector3d EulerZyx(const Eigen::Matrix3d& rotation);

}  // namespace keypose
