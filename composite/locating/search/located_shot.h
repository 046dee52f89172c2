// What is known of a filmed shot before its camera is looked for, and what is found.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "composite/locating/search/find_place.h"

namespace keypose::composite {

/// A picture of the empty set by a moving camera.
struct TimedPlate {
  double time = 0;  ///< on the film's clock, as LocateFrame::time
  Image8 picture;   ///< of the frames' size; RGB or grey
};

struct ShotInput {
  const Mesh* mesh = nullptr;       ///< faces, and UVs if there is a texture
  std::vector<PointsX3> poses;      ///< V x 3 each
  const Image8* texture = nullptr;  ///< null: unknown
  std::vector<LocateFrame> frames;  ///< pictures of one size; at least one
  Camera camera;                    ///< of that size; its focal length is known or a start
  double focal_deviation = 0;       ///< of its logarithm; 0: not known
  bool focal_fixed = false;         ///< it is given, and not improved
  bool solve_k1 = true;
  bool still = true;               ///< the camera does not move
  std::vector<TimedPlate> plates;  ///< of a camera that moves, ascending in time; may be empty
  /// Only by the clicks that each frame has, and where there is a matte by a few rounds of outlines
  /// at the smallest size.
  bool quick = false;
};

struct LocatedFrame {
  Placement at;
  std::string method;
  int inliers = 0;         ///< features that agree
  double contour_px = 0;   ///< mean distance of the outlines, both ways; 0 without a matte
  double iou = 0;          ///< of matte and mesh
  double correlation = 0;  ///< of grey values; 0 without texture
  double turn_ratio = 0;   ///< least over greatest eigenvalue of the turns, by outlines
  double rival_ratio = 0;  ///< FoundPlace::rival_ratio
  std::vector<OutlineMatch> outlines;  ///< what the mesh and the filmed figure differ by
  Image8 matte;                        ///< given or made
  bool left_out = false;               ///< the place is not believed
  /// Of a moving camera that the set shows: x in world is x in the set. Where the character moves
  /// in it as its mesh does, this is `at`'s.
  std::optional<Rigid3> camera_from_world;
};

/// Where a moving camera was between two frames, by a plate.
struct TimedCamera {
  double time = 0;
  Rigid3 camera_from_world;
};
/// What the set behind the character says of a moving camera.
struct SetFinding {
  int places = 0;              ///< of the set
  int on_table = 0;            ///< of them
  double rms_px = 0;           ///< of their sightings
  double focal_deviation = 0;  ///< of the focal length's logarithm, with all that is known
  std::vector<TimedCamera> between;
};

struct LocatedShot {
  std::vector<LocatedFrame> frames;
  Camera camera;
  std::string focal;               ///< "exif", "solved", "given" or "kept"
  double focal_deviation = 0;      ///< relative
  double profile_deviation = 1;    ///< of the pictures alone
  double matte_offset_px = 0;      ///< by which mattes lie outside of the mesh all round
  double center_deviation_px = 0;  ///< of the lens's centre if it were solved; 0: not measured
  bool one_place = false;          ///< one place serves all frames, since the meshes move as filmed
  std::optional<SetFinding> set;   ///< none: the camera stands, or the set shows too little
};

}  // namespace keypose::composite
