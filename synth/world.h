// A clay character with known truth: its surface, its named points, and its poses. What tests, the
// demo and the benchmarks live on.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/mesh.h"
#include "synth/clay.h"
#include "synth/pose.h"

namespace keypose::synth {

/// A named material point: a vertex of the truth surface, the same in every pose.
struct TruthLandmark {
  std::string name;
  int vertex = -1;
};

struct World {
  Clay clay;
  Mesh
      rest;  ///< truth surface in the rest pose: points and faces; about 0.2 m high, z up, on z = 0
  double spacing_m = 0.002;  ///< of the rest surface
  PointsX3 smooth;  ///< its vertices without the finger-prints, which may move the surface; empty:
                    ///< as rest.points
  std::vector<TruthLandmark> landmarks;  ///< 16 or so
  /// the character's repertoire: rest, bent, wave, bow, squash, twist, hip
  std::vector<Pose> poses;

  /// @throws UsageError  no pose of that name; lists those there are
  const Pose& PoseNamed(const std::string& name) const;
};

struct WorldOptions {
  std::string character = "creature";  ///< creature: the demo's | columns: a torso on four columns
                                       ///< that one sees through, genus 3
  std::uint64_t seed = 1;  ///< 1 is the demo's character; others vary proportions, colours, spots
  /// of the polygonisation; 0.002 gives about 100k vertices, 0.005 some 15k
  double spacing_m = 0.002;
  std::string texture = "rich";  ///< rich | weak | none: how much grain the paint has; none is
                                 ///< plain lumps of clay without a spot
  bool prints_move = false;  ///< finger-prints move the surface itself; else they only shade, as a
                             ///< coarse surface cannot hold them
  double print_height_m = 0.00004,
         print_spacing_m = 0.0012;  ///< of their ridges: crest over mean surface, crest to crest
};

/// A lopsided clay creature of random proportions: no two sides alike, so that no view can be
/// mistaken for another.
/// @throws UsageError  unknown character or texture @throws InputError  spacing_m out of (0.0003,
/// 0.02), or too wide for prints that move the surface
World MakeWorld(const WorldOptions& options = {});

/// The world's surface in a pose: vertex i is the same material point as vertex i of world.rest.
/// With vertex colours of the paint if asked.
Mesh TruthSurface(const World& world, const Pose& pose, bool with_colors = false);

/// What one sees of the world's surface in a pose: the surface itself, or, of a pose that touches,
/// the outer surface of the same fineness.
Mesh SeenSurface(const World& world, const Pose& pose);

/// Positions of the landmarks in a pose, L x 3 [m].
PointsX3 LandmarkPositions(const World& world, const Pose& pose);

}  // namespace keypose::synth
