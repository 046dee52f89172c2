// Pairs of photographs that share only a plane.
//
// A printed mat repeats itself: turned by one tick of its scale it looks as before, and two
// photographs then match at a turn that is off by tens of degrees. The figure on it does not
// repeat, and stands out of the plane. So where pairs with depth suffice, flat ones are not used
// (see rotation_cycles.h).
#pragma once

#include <vector>

#include "reconstruct/matching/verification.h"

namespace keypose::reconstruct {

struct FlatPairOptions {
  double on_plane_px = 6;  ///< distance from where the plane's homography puts a match
  int fewest_off = 10;     ///< matches off the plane of a pair with depth
  double share_off = 0.2;  ///< and their share of its matches
};

/// How many matches do not follow the homography that most do. Same result for any thread count.
int MatchesOffPlane(const Features& first, const Features& second, const PairMatches& pair,
                    double on_plane_px);

/// Which pairs share only a plane.
/// @param error_scale  times the options' pixels, for photographs that were reduced
std::vector<char> FlatPairs(const std::vector<Features>& features, const FlatPairOptions& options,
                            double error_scale, const std::vector<Verified>& verified);

}  // namespace keypose::reconstruct
