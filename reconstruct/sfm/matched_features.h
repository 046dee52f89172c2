// First half of sfm: features, matches, and the matches that pass the geometric test.
#pragma once

#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/stopwatch.h"

namespace keypose {
struct ImageSet;
}

namespace keypose::reconstruct {

/// Features of the photographs and their matches.
struct MatchedFeatures {
  Camera camera;  ///< before any adjustment
  bool focal_known = false;
  std::vector<Features> features;
  std::vector<PairMatches> matches;   ///< raw, including pairs with few matches
  std::vector<PairMatches> verified;  ///< of pairs that pass the geometric test
  std::vector<char> upside_down;      ///< by image; see FindUpsideDown
};

std::vector<std::string> NamesOf(const ImageSet& set);

/// Features, matches and verified matches of the set; the verified ones are also written to a
/// COLMAP database.
/// @param fine  also features at twice the photographs' size
/// @throws InputError  photographs of different sizes
MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, bool fine, Stopwatch& watch);

}  // namespace keypose::reconstruct
