// A hand and forearm that reach into a photograph.
#pragma once

#include <cstdint>

#include "core/image.h"

namespace keypose::synth {

/// Draws a forearm, a palm and fingers over linear light: round cones in the image's plane with
/// soft shading and the grain of skin. They come in from the left or right border, and the
/// fingertips lie over the figure.
///
/// @param linear  RGB, 1 is white; changed where the hand is
/// @param mask    255 where the figure is, of the same size; cleared where the hand covers at least
/// half of a pixel
/// @param seed    of side, height and slant. An empty mask: the hand reaches for the image's
/// middle.
void HoldHand(ImageF& linear, Image8& mask, std::uint64_t seed);

}  // namespace keypose::synth
