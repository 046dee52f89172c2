// A hand and forearm that reach into a photograph.
#pragma once

#include <cstdint>

#include "core/values/image.h"

namespace keypose::synth {

/// Draws a forearm, a palm and fingers into a linear image: round cones in the image plane with
/// soft shading and skin grain. They come from the left or right border, and the fingertips cover
/// the figure.
///
/// @param linear  RGB, 1 is white; overwritten where the hand is
/// @param mask    255 on the figure, same size; cleared where the hand covers at least half of a
/// pixel
/// @param seed    decides side, height and slant. If the mask is empty, the hand reaches for the
/// image's middle.
void HoldHand(ImageF& linear, Image8& mask, std::uint64_t seed);

}  // namespace keypose::synth
