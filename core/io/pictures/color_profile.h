// Colours of pictures with an ICC profile, such as Display P3 of phones and Adobe RGB of cameras,
// as sRGB.
#pragma once

#include <string>

#include "core/values/image.h"
#include "core/values/image16.h"

namespace keypose {

/// The picture in sRGB, by relative colorimetry; colours beyond sRGB are clipped. As it is where
/// the profile is empty, is sRGB already (no level moves by more than one), cannot be read, or is
/// not of RGB.
/// @param image    H x W x 3
/// @param profile  the bytes of an ICC profile
/// Source: ICC.1:2010; by Little CMS.
Image8 InSrgb(Image8 image, const std::string& profile);
/// The same of 16 bits, to a few of their steps. What 8 bits take for sRGB is sRGB here too.
Image16 InSrgb(Image16 image, const std::string& profile);

/// The bytes of a profile with sRGB's transfer function, white point D65 and these primaries, as
/// chromaticities x, y. For containers that say primaries without a profile.
std::string ProfileOf(const double (&red)[2], const double (&green)[2], const double (&blue)[2]);
std::string DisplayP3Profile();

}  // namespace keypose
