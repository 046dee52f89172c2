// The border of a mask put where the object covers half of a pixel.
#pragma once

#include "core/image.h"

namespace keypose::capture {

/// Decides the pixels beside a mask's border anew: inside is what shows more of the object than of
/// the background.
///
/// A pixel on the border mixes the light of both. How much of each it holds is read off its place
/// between the mean colour of the object just inside of the border and that of the background just
/// outside, in linear light: in the photograph's own values a dark object before a bright
/// background looks smaller than it is. Pixels where the two hardly differ, or less than either
/// varies, stay as they are.
///
/// @param image  RGB, sRGB encoded
/// @param mask   same size, 255 or 0; its border at most half a pixel outside of the true one, or
/// one inside Source: the line of mixtures of Ruzon & Tomasi, "Alpha estimation in natural images",
/// CVPR 2000, with one colour on either side.
void MatteBoundary(const Image8& image, Image8& mask);

}  // namespace keypose::capture
