// First half of sfm: what the photographs show. Features, matches, and the matches that stand the
// geometric test.
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

/// What the photographs show: features and what matches.
struct MatchedFeatures {
  Camera camera;  ///< as assumed before any adjustment
  bool focal_known = false;
  std::vector<Features> features;
  std::vector<PairMatches> matches;   ///< raw, however few a pair has
  std::vector<PairMatches> verified;  ///< those of pairs that stand the geometric test
  std::vector<char> upside_down;      ///< by image; see FindUpsideDown
};

std::vector<std::string> NamesOf(const ImageSet& set);

/// Features, matches and verified matches of the set, the last in a COLMAP database.
/// @param fine  features from twice the photographs' size too
/// @throws InputError  photographs of different sizes
MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, bool fine, Stopwatch& watch);

}  // namespace keypose::reconstruct
