// All that the page and report.json are made from, as values: the run's record, pictures, distances, distortions.
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

namespace keypose::report {

struct Picture {
  std::string caption;
  Image8 image;
};

struct PosePart {
  std::string name;
  std::vector<Picture> sides;      ///< textured, from all round; clay when there is no texture
  std::vector<Picture> shape;      ///< the closed mesh alone, with its edges
  std::optional<Picture> cloud;    ///< the dense points
  std::optional<Picture> masks;    ///< contact sheet
  std::optional<Picture> cameras;  ///< where they were placed, as sfm drew it
  std::optional<Picture> texture;
  int faces = 0, vertices = 0;
};

/// The template registered onto another pose.
struct PairPart {
  const StepRecord* step = nullptr;
  double diagonal = 0;  ///< of the target; distances below are over it
  OneWayDistance to_target, from_target;
  double scale_top = 0;                     ///< the colour scale's upper end, over the diagonal
  std::vector<Picture> registered, target;  ///< coloured by distance
  std::vector<Picture> carried;             ///< the checker carried over from the template, as register drew it
};

struct AnimationPart {
  std::vector<FrameDistortion> frames;
  std::vector<Picture> film;
  std::optional<FaceDistortion> faces;  ///< at `faces_t`
  double faces_t = 0;
  int face_count = 0;
  int keys = 0;
};

struct Contents {
  RunRecord run;
  std::vector<PosePart> poses;
  std::vector<PairPart> pairs;
  std::optional<AnimationPart> animation;
  std::vector<std::string> troubles;  ///< what could not be shown, and why
};

enum class Grade { kGood, kLook, kBad, kInfo };
struct Verdict {
  Grade grade;
  std::string where;  ///< pose or step
  std::string text;
};
/// What is good, and what to look at, from the measurements; worst first.
std::vector<Verdict> Judge(const Contents& contents);

/// Turns a picture into a data URI.
using Encoder = std::function<std::string(const Image8&)>;

/// index.html. Missing parts are said to be missing.
std::string BuildPage(const Contents& contents, const Encoder& encode);
/// report.json.
std::string BuildJson(const Contents& contents);

}  // namespace keypose::report
