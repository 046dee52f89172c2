// A hand, a tool or a thumb that reaches into a photograph.
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

/// Draws a wooden modelling tool with a steel tip, which comes from the left or right border and
/// covers a strip of the figure, 0.04 to 0.06 of the picture's height wide. Arguments as above.
void HoldTool(ImageF& linear, Image8& mask, std::uint64_t seed);

/// Draws a thumb that lies before the lens: out of focus, from a corner or the middle of an edge,
/// with its tip 0.2 to 0.45 of the picture's height inside.
/// @param linear  RGB, 1 is white; overwritten where the thumb is
/// @param seed    decides side, length and width
void HoldThumb(ImageF& linear, std::uint64_t seed);

}  // namespace keypose::synth
