// First half of sfm: features, matches, and the matches that pass the geometric test.
#pragma once

#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/stopwatch.h"
#include "reconstruct/surroundings/figure_motion.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// Features of the photographs and their matches.
struct MatchedFeatures {
  Camera camera;  ///< of the first photograph, before any adjustment
  bool focal_known = false;
  std::vector<Camera> lenses;      ///< all of them; see SetLenses
  std::vector<int> lens_of_image;  ///< for each photograph the index of its lens
  std::vector<Features> features;
  std::vector<PairMatches> matches;   ///< raw, including pairs with few matches
  std::vector<PairMatches> verified;  ///< of pairs that pass the geometric test
  std::vector<char> upside_down;      ///< by image; see FindUpsideDown
  bool whole = false;                 ///< of whole photographs, not of the masks alone
  FigureMotion motion;                ///< of whole photographs; else empty
};

std::vector<std::string> NamesOf(const ImageSet& set);

/// Features, matches and verified matches of the set; the verified ones are also written to a
/// COLMAP database.
/// Of whole photographs, features that move otherwise than the figure have no matches.
/// @param masks  at any size, one for each image, empty where there is none: where the figure is
/// likely; used for whole photographs only
MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, const FeatureKind& kind,
                              const std::vector<Image8>& masks, Stopwatch& watch);

}  // namespace keypose::reconstruct
