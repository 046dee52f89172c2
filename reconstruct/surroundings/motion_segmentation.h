// Which features of whole photographs move together.
//
// Between photographs of a room, what is seen moves in several ways: a mat turns with the figure,
// the wall behind it stays, a camera in the hand moves both. Structure from motion follows
// whichever has more matches, which is seldom the figure. Two things tell features apart: before a
// tripod the room stays in place in the picture; and cameras that fit one motion do not fit the
// matches of the other. Single matches err, so a feature belongs where its neighbours in the
// picture belong.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/progress.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/pair_list.h"

namespace keypose::reconstruct {

/// For each image and feature: positive if it moves as what is asked for, negative if not, 0 if
/// nothing is known. The size is the number of pairs that say so, less those that deny it.
using MotionVotes = std::vector<std::vector<int>>;

struct MotionSegmentationOptions {
  double in_place = 0.001;  ///< of the longer side, and at least a pixel: matches that move less
                            ///< stay in place
  /// times this limit: matches that move less decide nothing, since places of blurred features are
  /// that inexact
  double nearly_in_place = 8;
  int fewest = 8;         ///< matches in place of a pair, and likewise matches that move
  double fits_px = 4;     ///< from the epipolar line: the match fits the cameras
  double misses_px = 12;  ///< farther off it does not
  int neighbours = 10;    ///< features around one that decide where it belongs
};

/// Votes for what turns before a tripod, against what stays in place there. All are 0 where the
/// camera was not fixed.
/// @param matches  raw matches of pairs, also those that stay in place
/// @param pairs  set to all pairs of photographs from one tripod, sorted
MotionVotes TurnsBeforeTripod(const std::vector<Features>& features,
                              const std::vector<PairMatches>& matches, int longer_side_px,
                              const MotionSegmentationOptions& options,
                              std::vector<ImagePair>* pairs);

/// Leaves out matches that stay in place or nearly so in a pair before one tripod.
/// @return how many
int LeaveOutNearlyInPlace(const Features& first, const Features& second, int longer_side_px,
                          const MotionSegmentationOptions& options, PairMatches& pair);

/// Votes for what does not fit the cameras, against what does.
/// @param matches  raw matches of pairs
/// @param view_of_image  index into scene.views, or -1
MotionVotes MovesOtherwise(const std::vector<Features>& features,
                           const std::vector<PairMatches>& matches, const Scene& scene,
                           const std::vector<int>& view_of_image,
                           const MotionSegmentationOptions& options, Progress* progress = nullptr);

/// Where what is asked for is, in each picture: 255 where most of the nearest features with votes
/// are for it. Empty for a picture with hardly any votes.
/// @param lens  of each image
/// Same result for any thread count.
std::vector<Image8> MotionRegions(const std::vector<Features>& features, const MotionVotes& votes,
                                  const std::vector<Camera>& lens,
                                  const MotionSegmentationOptions& options);

/// Features of each image that have a vote for what is asked for and lie in its region.
/// @param regions  as of MotionRegions, at any size
std::vector<int> CountInRegions(const std::vector<Features>& features, const MotionVotes& votes,
                                const std::vector<Camera>& lens,
                                const std::vector<Image8>& regions);

/// How far cameras turn round what they look at: the mean angle between the optical frames of two
/// [radians].
double MeanTurn(const std::vector<View>& views);

}  // namespace keypose::reconstruct
