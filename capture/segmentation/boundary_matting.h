// Moves the border of a mask to where the object covers half of a pixel.
#pragma once

#include "core/values/image.h"

namespace keypose::capture {

/// Decides the pixels beside a mask's border again: a pixel is inside if it shows more of the
/// object than of the background.
///
/// A pixel on the border mixes the light of both. The mixture is estimated from its colour relative
/// to the mean colour of the object just inside of the border and that of the background just
/// outside, in linear light: in the photograph's sRGB values a dark object in front of a bright
/// background would appear too small. Pixels stay unchanged if the two colours hardly differ, or
/// differ by less than their variation.
///
/// @param image  RGB, sRGB encoded
/// @param mask   same size, 255 or 0; its border at most half a pixel outside of the true one, or
/// one pixel inside
/// Source: the line of mixtures of Ruzon & Tomasi, "Alpha estimation in natural images", CVPR 2000,
/// with one colour on each side.
void MatteBoundary(const Image8& image, Image8& mask);

}  // namespace keypose::capture
