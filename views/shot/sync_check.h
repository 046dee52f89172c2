// Whether numbered pictures of several cameras run together: picture N of each is the same moment.
#pragma once

#include <string>
#include <vector>

#include "views/shot/shot_camera.h"

namespace keypose {

/// Offsets between clocks, and films of other lengths, are for the stages; what drifts is not.
/// @throws InputError  a numbered picture that only some cameras lack, after which its camera would
/// run ahead of the others. Names camera, frame and cure
void RequireSameGaps(const std::vector<ShotCamera>& cameras);

/// On numbers that are missing among a camera's pictures, which are counted as if none were; empty:
/// none is, or their names do not tell.
std::string WordsOnGaps(const ShotCamera& camera);

}  // namespace keypose
