// The data for the page and report.json: the run's record, pictures, distances, distortions.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/values/image.h"
#include "report/evidence/distortion_tables.h"
#include "report/evidence/one_way_distance.h"
#include "report/evidence/run_record.h"
#include "report/evidence/view_evidence.h"

namespace keypose::report {

struct Picture {
  std::string caption;
  Image8 image;
};

/// Encodes a picture as a data URI.
using Encoder = std::function<std::string(const Image8&)>;

/// Where a photograph was taken from.
struct CameraPlace {
  std::string name;
  double azimuth_deg = 0, height_deg = 0;  ///< around the figure, and above its middle
  double outline_off = 0;                  ///< outline_off of its view, see ViewEvidence
};

struct PosePart {
  std::string name;
  std::vector<Picture> sides;      ///< textured, from all sides; clay if there is no texture
  std::vector<Picture> shape;      ///< the closed mesh alone, with its edges
  std::optional<Picture> cloud;    ///< the dense points
  std::optional<Picture> masks;    ///< contact sheet
  std::optional<Picture> cameras;  ///< their positions, as drawn by sfm
  std::optional<Picture> painted;  ///< of a shot: films beside the mesh that was painted from them
  std::vector<CameraPlace> places;
  std::optional<Picture> texture;
  /// the textured mesh compared with the photographs; no views if there is nothing to compare
  PoseEvidence evidence;
  bool masks_replaced = false;  ///< compared with masks that replaced the first ones, in a room
  std::vector<Picture> worst;   ///< photograph beside render, of the worst views
  int faces = 0, vertices = 0;
};

/// The template registered onto another pose.
struct PairPart {
  const StepRecord* step = nullptr;
  double diagonal = 0;  ///< of the target; the distances below are divided by it
  OneWayDistance to_target, from_target;
  double scale_top = 0;                     ///< the colour scale's upper end, over the diagonal
  std::vector<Picture> registered, target;  ///< coloured by distance
  /// where one more landmark would help, marked on the template and on the pose
  std::vector<Picture> advice;
  /// the template's checker pattern on both meshes, as drawn by register
  std::vector<Picture> carried;
};

struct AnimationPart {
  std::vector<FrameDistortion> frames;
  std::vector<Picture> film;
  std::optional<FaceDistortion> faces;  ///< at `faces_t`
  double faces_t = 0;
  int face_count = 0;
  int keys = 0;
};

/// The player of the animation, or of the template alone.
struct PlayerPart {
  std::string json;  ///< the data for report/player/data.js; empty if it would be too large
  int pictures = 1, keys = 1;
  int stored = 1, distinct = 1;  ///< frames stored, and distinct frames in all
  bool textured = false;
  std::optional<Picture> poster;
};

struct Contents {
  RunRecord run;
  std::vector<PosePart> poses;
  std::vector<PairPart> pairs;
  std::optional<AnimationPart> animation;
  std::optional<PlayerPart> player;
  std::vector<std::string> troubles;  ///< what cannot be shown, and why
};

}  // namespace keypose::report
