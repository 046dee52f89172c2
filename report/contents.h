// All that the page and report.json are made from, as values: the run's record, pictures,
// distances, distortions.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/image.h"
#include "report/distortion.h"
#include "report/run_record.h"
#include "report/surface_distance.h"
#include "report/view_evidence.h"

namespace keypose::report {

struct Picture {
  std::string caption;
  Image8 image;
};

/// Where a photograph was taken from.
struct CameraPlace {
  std::string name;
  double azimuth_deg = 0, height_deg = 0;  ///< around the figure, and above its middle
  double outline_off = 0;                  ///< of its view, see ViewEvidence
};

struct PosePart {
  std::string name;
  std::vector<Picture> sides;      ///< textured, from all round; clay when there is no texture
  std::vector<Picture> shape;      ///< the closed mesh alone, with its edges
  std::optional<Picture> cloud;    ///< the dense points
  std::optional<Picture> masks;    ///< contact sheet
  std::optional<Picture> cameras;  ///< where they were placed, as sfm drew it
  std::vector<CameraPlace> places;
  std::optional<Picture> texture;
  PoseEvidence evidence;  ///< the textured mesh against the photographs; no views when there was
                          ///< nothing to compare
  std::vector<Picture> worst;  ///< photograph beside render, of the worst views
  int faces = 0, vertices = 0;
};

/// The template registered onto another pose.
struct PairPart {
  const StepRecord* step = nullptr;
  double diagonal = 0;  ///< of the target; distances below are over it
  OneWayDistance to_target, from_target;
  double scale_top = 0;                     ///< the colour scale's upper end, over the diagonal
  std::vector<Picture> registered, target;  ///< coloured by distance
  /// where one more landmark would help, marked on the template and on the pose
  std::vector<Picture> advice;
  /// the checker carried over from the template, as register drew it
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
  std::string json;  ///< what report/player/data.js unpacks; empty when it would be too large
  int pictures = 1, keys = 1;
  int stored = 1, distinct = 1;  ///< frames that it holds, of all that differ
  bool textured = false;
  std::optional<Picture> poster;
};

struct Contents {
  RunRecord run;
  std::vector<PosePart> poses;
  std::vector<PairPart> pairs;
  std::optional<AnimationPart> animation;
  std::optional<PlayerPart> player;
  std::vector<std::string> troubles;  ///< what could not be shown, and why
};

enum class Grade { kGood, kLook, kWrong, kNote };
/// "good", "look", "wrong", "note".
const char* WordOf(Grade grade);

/// One thing that was judged.
struct Finding {
  Grade grade;
  std::string pose;   ///< empty: of the animation, or of the whole project
  std::string where;  ///< step
  std::string text;   ///< HTML
  std::string cure;   ///< what to do, plain text; empty where nothing is to be done
};
/// All that is judged, worst first. The limits are in limits.h.
std::vector<Finding> FindAll(const Contents& contents);

/// Whether a pose (or "animation") is good enough.
struct Verdict {
  std::string about;
  Grade grade;
  std::string why;   ///< HTML: what decided
  std::string cure;  ///< of what decided; empty when good
};
/// One a pose in the project's order, as bad as the worst finding on it; then one for the animation
/// where it is not good.
std::vector<Verdict> Judge(const Contents& contents, const std::vector<Finding>& findings);
/// Without its HTML.
std::string Plain(const std::string& html);

/// Turns a picture into a data URI.
using Encoder = std::function<std::string(const Image8&)>;

/// index.html. Missing parts are said to be missing.
std::string BuildPage(const Contents& contents, const Encoder& encode);
/// report.json.
std::string BuildJson(const Contents& contents);

}  // namespace keypose::report
