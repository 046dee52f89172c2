// An actor for performance capture: a dressed body on the skeleton of a motion clip, with its
// joints known in every frame. Its shape, its skin and its clothes are made here and share nothing
// with the template that tracks it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/motion_clip.h"

namespace keypose::synth {

struct PerformerOptions {
  std::uint64_t seed = 1;    ///< proportions, girths, clothes, colours
  double spacing_m = 0.012;  ///< of the surface's vertices
  double cloth_m = 0.008;    ///< how far cloth waves about its place; a third of it moves in time
};

/// A motion of our own, in place of a recorded one: an actor who walks on a circle, swings and
/// raises the arms, bends and turns. Joints are named as in the clips of the CMU database. Metres,
/// y up.
MotionClip MakeOwnMotion(int frames, double frames_per_second, std::uint64_t seed);

class Performer {
 public:
  /// @param clip  with the joints Hips, LeftHip, LeftKnee, LeftAnkle, LeftToe, Chest, Chest2, Neck,
  /// Head, LeftShoulder, LeftElbow, LeftWrist, LFingers, and those of the right side; y up, any
  /// unit
  /// @throws InputError  a joint is missing; names it
  Performer(const MotionClip& clip, const PerformerOptions& options);

  /// Stands where another one of the same clip stands: meshes of two spacings have lowest points of
  /// their own.
  void PlaceAs(const Performer& other) { shift_ = other.shift_; }

  int frame_count() const { return clip_.frame_count(); }
  /// The motion as it is filmed: metres, with arms that stay outside of the trunk (FreeArms).
  const MotionClip& clip() const { return clip_; }
  /// Faces, and the paint of the vertices without light, sRGB.
  const Mesh& bind() const { return bind_; }
  /// Vertices in a frame [m], z up; the lowest point of all frames is on z = 0, the middle of the
  /// path at x = y = 0. Pure: may be called from several threads.
  PointsX3 Points(int frame) const;
  /// Names of the joints that are compared: those of the limbs, as in the template's BVH file.
  /// (Where a neck or a spine bends is each skeleton's own choice.)
  static const std::vector<std::string>& JointNames();
  /// Their places in a frame [m], one row each.
  PointsX3 Joints(int frame) const;

 private:
  std::vector<Rigid3> WorldFrames(int frame) const;  // z up, metres, before `shift_`
  void Place();

  MotionClip clip_;  // in metres
  PerformerOptions options_;
  Mesh bind_;
  PointsX3 bind_normals_;
  std::vector<Rigid3> world_from_bind_;                       // joints' frames in the bind pose
  std::vector<std::vector<std::pair<int, double>>> weights_;  // per vertex: joint, weight
  Eigen::VectorXd cloth_;                                     // per vertex: 1 on cloth, 0 on skin
  Eigen::Vector3d shift_ = Eigen::Vector3d::Zero();
};

}  // namespace keypose::synth
