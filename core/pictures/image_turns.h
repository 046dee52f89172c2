// Rotation of whole pictures.
#pragma once

#include "core/values/image.h"

namespace keypose {

/// The picture rotated by 180 degrees. Any number of channels.
Image8 TurnedOver(const Image8& image);
/// Rotated by 90 degrees, clockwise.
Image8 QuarterTurned(const Image8& image);

/// The picture upright, from the way in which it is stored.
/// @param orientation  1 to 8, as EXIF counts: 1 is upright, 3 upside down, 6 needs a quarter turn
/// clockwise, 8 one back; 2, 4, 5 and 7 are mirrored too
template <class T>
ImageT<T> Oriented(ImageT<T> image, int orientation);

}  // namespace keypose
