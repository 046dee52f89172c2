// A shot by the clicks in each of its frames, while a person waits.
#pragma once

#include "composite/locating/search/shot_frames.h"

namespace keypose::composite {

/// @param frames  need not have been found; each has clicks
/// @throws InputError  clicks that do not agree
/// Same bits for any thread count.
LocatedShot LocateByClicks(ShotFrames& frames);

}  // namespace keypose::composite
