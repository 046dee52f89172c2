// First half of sfm: features, matches, and the matches that pass the geometric test.
#pragma once

#include <string>
#include <vector>

#include "core/stage/stage.h"
#include "reconstruct/sfm/colmap_programs.h"
#include "reconstruct/sfm/stopwatch.h"
#include "reconstruct/surroundings/motion_segmentation.h"

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
  bool in_room = false;               ///< also of what the figure stands on, or of all
  MotionVotes turning;                ///< of whole photographs: see TurnsBeforeTripod; else empty
  /// pairs before one tripod: in these, what stays in place or nearly so has no matches
  std::vector<ImagePair> tripod_pairs;
};

std::vector<std::string> NamesOf(const ImageSet& set);
/// The lens of each photograph.
std::vector<Camera> LensOfEach(const MatchedFeatures& matched);

/// Features of the set, in a new database, and their raw matches.
/// @param tripod_pairs  sorted; see MatchedFeatures. Of whole photographs they are found
MatchedFeatures MatchPhotographs(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                                 const SfmOptions& options, const FeatureKind& kind,
                                 Stopwatch& watch, std::vector<ImagePair> tripod_pairs = {});

/// Finds the matches that pass the geometric test, and writes them to the database as well, in
/// place of those found before.
/// @param without_repeated  pairs that match by what repeats itself are left out
void VerifyMatches(StageContext& stage, const SfmFiles& files, const SfmOptions& options,
                   bool without_repeated, Stopwatch& watch, MatchedFeatures& matched);

/// Puts these verified matches in place of all, in `matched` and in the database.
void ReplaceVerified(std::vector<PairMatches> verified, const SfmFiles& files,
                     MatchedFeatures& matched);

/// Both, one after the other.
MatchedFeatures BuildDatabase(StageContext& stage, const ImageSet& set, const SfmFiles& files,
                              const SfmOptions& options, const FeatureKind& kind, Stopwatch& watch,
                              std::vector<ImagePair> tripod_pairs = {});

}  // namespace keypose::reconstruct
