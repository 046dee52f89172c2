// The camera of a filmed shot and the character's place in each of its frames.
#pragma once

#include "composite/locating/search/located_shot.h"
#include "core/values/progress.h"

namespace keypose::composite {

/// @throws InputError  a frame without character; a body that can be turned unseen; see FindPlace
/// Same bits for any thread count.
LocatedShot LocateShot(const ShotInput& input, Progress* progress = nullptr);

}  // namespace keypose::composite
