// Limbs that jump between two frames are followed on from the other side of the jump, arms that are
// hardly seen are searched for and followed from there, and the better of both courses is kept.
#pragma once

#include <functional>
#include <vector>

#include "motion/tracking/tracker.h"

namespace keypose::motion {

/// First guesses, tried on the generated performances with seeds 101, 211 and 212; the last three
/// on 101, 401 and 403.
struct RetrackingTuning {
  KEYPOSE_TUNED(double, kUnusual, 4);     ///< times the limb's usual second difference: a jump
  KEYPOSE_TUNED(double, kJump, 0.05);     ///< [m] of a jump's second difference at least
  KEYPOSE_TUNED(double, kMerged, 0.03);   ///< [m] between two courses of a limb: the same
  KEYPOSE_TUNED(double, kBetter, 0.97);   ///< factor on a frame's cost: surely less
  KEYPOSE_TUNED(double, kHopeless, 0.4);  ///< share of a frame's cost that is lost: given up
  KEYPOSE_TUNED(int, kLongest, 60);       ///< frames that a course is followed for
  KEYPOSE_TUNED(int, kEvery, 6);          ///< frames: in one of so many, arms are searched for
  KEYPOSE_TUNED(int, kCandidates, 2);     ///< of a search, the known pose among them
  KEYPOSE_TUNED(double, kSure, 0.2);      ///< share of a frame's cost that a found course gains
};

struct Retracking {
  int solved = 0;   ///< poses that were tried
  int changed = 0;  ///< times that a frame took another course of a limb
};

/// A tracker enters a wrong course unnoticed (an arm beside the filmed one, still within reach of
/// the outlines), and leaves it with a jump when the outlines draw it back. From there the right
/// course can be followed back to where the two parted. So each limb that jumps is followed on
/// beyond its jump, first backwards in time, then forwards, until it meets the course that was
/// known. Frames take the other course up to where the sum of what it gains is largest: two
/// courses with one change between them, by least cost.
///
/// A course that no jump leaves is not found so. Therefore an arm is searched for in some of the
/// frames in which less of it is seen alone than usual. Another place that costs less is followed
/// in both directions, and taken when it gains more than one frame's noise.
///
/// @param read    silhouettes of a frame; called limb after limb, in falling order of frames, then
///                in rising order; then around the frames that are searched, in rising order
/// @param frames  one take, in order; `found` stays what the tracker found
/// Cost: one SolvePose and one CoverageOf for each frame that a limb is followed through; a
/// SearchLimb and two SolvePose for a frame that is searched.
/// Same bits for any thread count.
Retracking RetrackLimbs(const BodyShape& shape,
                        const std::function<const std::vector<Silhouette>&(int)>& read,
                        std::vector<TrackedFrame>* frames);

}  // namespace keypose::motion
