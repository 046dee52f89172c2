// Which features of whole photographs move as the figure does.
//
// Between two photographs of a room, what is seen may move in several ways: a mat turns with the
// figure, the wall behind it stays, a camera in the hand moves both. Structure from motion follows
// whichever has more matches, which is seldom the figure. Here each pair's matches are separated
// into rigid motions, and the motion that the likely figure follows decides. What moves otherwise
// is left out in all pairs, also where it is all that two photographs share.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/progress.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/verification.h"

namespace keypose::reconstruct {

struct FigureMotionOptions {
  VerificationOptions verification;
  double in_place = 0.001;  ///< of the longer side, and at least a pixel: matches that move less
                            ///< stay in place
  int fewest = 20;          ///< matches of a second motion
  double of_rest = 0.25;    ///< and its share of the matches that the first motion leaves
  double clearly = 1.2;     ///< times the other's likely figure, for one motion to be the figure's
  int fewest_pairs = 3;     ///< pairs with two motions; with fewer all moves as one
};

struct FigureMotion {
  /// for each image and feature: 1 where it moves otherwise than the figure
  std::vector<std::vector<char>> left_behind;
  int pairs_in_two = 0;   ///< pairs whose matches follow two motions
  int pairs_decided = 0;  ///< of these, pairs in which the figure clearly follows one
  int features_left = 0;  ///< features that are left behind
};

/// @param features  by image
/// @param matches   raw matches of pairs, also those that stay in place
/// @param likely    by image, for each feature how likely it is on the figure, in [0, 1]
/// @param longer_side_px  of the photographs
/// Same result for any thread count.
FigureMotion FollowFigure(const std::vector<Features>& features,
                          const std::vector<PairMatches>& matches,
                          const std::vector<Eigen::VectorXf>& likely, int longer_side_px,
                          const FigureMotionOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
