// Joints whose encoder seems to be stuck.
#pragma once

#include <string>
#include <vector>

#include "armature/description/armature.h"

namespace keypose::armature {

/// An encoder that is stuck says nothing of it; but whoever poses a puppet by hand cannot move the
/// joints beside one without moving it by a count, and a joint that moved in each frame and then
/// stands still to the count, while a neighbour goes on, is suspicious.
/// @param frames  recorded ones, oldest first, of all joints
/// @return joints that moved in each of three frames, have stood still to the last bit in the three
/// after them, the last ones, while the nearest joint above or below moved in each
std::vector<int> StillJoints(const Armature& armature,
                             const std::vector<std::vector<double>>& frames);

/// A sentence on such a joint, and what to do.
/// @param since  the first frame in which it stood still
std::string StillWords(const std::string& joint, int since);

}  // namespace keypose::armature
