// Masks and mattes that a person gives: how they lie on their picture, and which side is the
// figure.
#pragma once

#include "core/values/image.h"

namespace keypose {

/// Whether an image has the shape of another size, to the rounding of either when one was resized.
bool HasShapeOf(const Image8& image, int width, int height);
/// Whether it can be brought over a picture: of its shape, and no smaller than an eighth of it.
bool CanLieOn(const Image8& matte, int width, int height);
/// Whether a matte of an upright picture lies as the picture's file stores it: on its side.
/// @param width        and height of the picture, upright
/// @param orientation  of its file, as EXIF counts
bool LiesAsStored(const Image8& matte, int width, int height, int orientation);

/// Whether it covers nothing at all: no more than noise, 8 of 255.
bool IsEmptyMatte(const Image8& matte);
/// @param levels  of 255
bool IsEmptyMatte(const ImageF& levels);
/// Whether it covers all of the picture, but for specks of a thousandth.
bool IsFullMatte(const Image8& matte);
/// Whether it covers nine tenths of the picture's border but not all of the picture: what surrounds
/// a figure does, a figure hardly ever.
bool CoversBorder(const Image8& matte);
/// 0 for 255 and 255 for 0.
Image8 InvertedMatte(Image8 matte);

}  // namespace keypose
