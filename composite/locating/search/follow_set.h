// The way of a moving camera by the set behind the character.
#pragma once

#include <optional>

#include "composite/locating/search/shot_frames.h"

namespace keypose::composite {

/// The camera by what stands still behind the character, which may have been moved by hand
/// meanwhile; world is the character's frame in the first picture. Sets the frames' cameras, and
/// their places for the lens that the set shows.
///
/// @param frames   found and refined
/// @param focal_deviation  of the focal length's logarithm, by the character in all frames
/// @return none: the camera stands, or the set shows too little; then nothing is changed but what a
/// better lens did to places
/// Same bits for any thread count.
std::optional<SetFinding> FollowSet(ShotFrames& frames, double focal_deviation, Progress* progress);

}  // namespace keypose::composite
