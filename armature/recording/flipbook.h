// The recorded frames as a ball-and-stick figure to flip through at once.
#pragma once

#include <string>

#include "armature/recording/joint_curves.h"

namespace keypose::armature {

/// Places of all nodes in each frame and the sticks between them, for a player:
/// {"fps", "step", "sticks": [[a, b], ...], "frames": [[[x, y, z], ...], ...]}.
std::string FlipbookJson(const Armature& armature, const JointCurves& curves);

/// A picture that moves by itself in any browser: seen from the side (+x), the last frame in grey
/// behind the one that is shown.
std::string FlipbookSvg(const Armature& armature, const JointCurves& curves);

}  // namespace keypose::armature
