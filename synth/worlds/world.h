// A clay character with known truth: its surface, its named points, and its poses. Used by tests,
// the demo and the benchmarks.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "synth/worlds/clay.h"
#include "synth/worlds/limb_pose.h"
#include "synth/worlds/pose.h"

namespace keypose::synth {

/// A named material point: a vertex of the truth surface, the same in every pose.
struct TruthLandmark {
  std::string name;
  int vertex = -1;
};

struct World {
  Clay clay;
  Mesh rest;  ///< true surface in the rest pose: points and faces; about 0.2 m high, z up, on z = 0
  double spacing_m = 0.002;  ///< of the rest surface
  PointsX3 smooth;           ///< its vertices without finger-prints; empty: the same as rest.points
  std::vector<TruthLandmark> landmarks;  ///< about 16
  /// the character's poses: rest, bent, wave, bow, squash, twist, hip; `limbs` if asked for
  std::vector<Pose> poses;
  std::vector<PosableLimb> limbs;  ///< that `limbs` moves: arms, ear, tail; columns: none

  /// @throws UsageError  no pose of that name; lists the known ones
  const Pose& PoseNamed(const std::string& name) const;
};

struct WorldOptions {
  /// creature: the demo's character | columns: a torso on four columns, with windows, genus 3
  std::string character = "creature";
  std::uint64_t seed = 1;  ///< 1 is the demo's character; others vary proportions, colours, spots
  /// of the pose `limbs`: every limb moved by 30 to 120 degrees; 0: the world has no such pose
  std::uint64_t pose_seed = 0;
  /// of the polygonisation; 0.002 gives about 100k vertices, 0.005 about 15k
  double spacing_m = 0.002;
  /// rich | weak | none: strength of the paint's grain; none: plain lumps of clay without spots
  std::string texture = "rich";
  /// finger-prints move the surface; otherwise they only affect shading, since a coarse surface
  /// cannot represent them
  bool prints_move = false;
  double print_height_m = 0.00004,
         /// of the ridges: height of the crest over the mean surface, distance from crest to crest
      print_spacing_m = 0.0012;
};

/// An asymmetric clay creature of random proportions: all sides differ, so that no view can be
/// mistaken for another.
/// @throws UsageError  unknown character or texture, a pose_seed for columns
/// @throws InputError  spacing_m outside (0.0003, 0.02), or too large for prints that move the
/// surface; no room for a limb of the pose `limbs`
World MakeWorld(const WorldOptions& options = {});

/// The world's surface in a pose: vertex i is the same material point as vertex i of world.rest.
/// With vertex colours of the paint if `with_colors`.
Mesh TruthSurface(const World& world, const Pose& pose, bool with_colors = false);

/// The visible surface of the world in a pose: the surface itself, or for a pose that touches, its
/// outer surface at the same resolution.
Mesh SeenSurface(const World& world, const Pose& pose);

/// Positions of the landmarks in a pose, L x 3 [m].
PointsX3 LandmarkPositions(const World& world, const Pose& pose);

}  // namespace keypose::synth
