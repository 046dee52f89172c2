// Arms that do not pass through the body.
#pragma once

#include <vector>

#include "core/values/motion_clip.h"
#include "synth/worlds/flesh.h"

namespace keypose::synth {

/// A recorded motion moved another body than the one that a film dresses it in, so that a hand that
/// lay at the belly may lie inside, or an elbow on a thigh. Turns such arms about their shoulders,
/// as little as brings forearm and hand out of trunk, thighs and head, and the elbow out of thighs
/// and head, smoothly over the frames. Skin may press into clothes by half of its radius. Other
/// frames keep their bits.
///
/// @param lumps            of the whole body
/// @param world_from_bind  the joints' frames in the bind pose (UprightFrames)
/// @param clip             metres; y up. Its shoulders turn about three axes
/// @throws InputError  a shoulder turns about fewer axes
/// Same bits for any thread count.
void FreeArms(const std::vector<Flesh>& lumps, const std::vector<Rigid3>& world_from_bind,
              MotionClip* clip);

}  // namespace keypose::synth
