// Mattes as a person or another program made them: masks whose borders may be soft.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/image.h"

namespace keypose {

/// A matte in a file, and what had to be done to it.
struct DrawnMatte {
  Image8 matte;            ///< 255 where all is covered, 0 where nothing is
  bool stretched = false;  ///< its two levels were others, such as 0 and 1
};

/// By its alpha where that differs between pixels or hides all of them, else by its levels. Two
/// levels are 0 and 255, however small both are, unless fewer than one pixel in 2000 has one of
/// them; one alone and more are kept, as are those of a black JPEG or HEIC with noise. The EXIF
/// orientation is applied.
/// @throws InputError  a picture in colours; many levels, all of them dark @throws DiskError
DrawnMatte ReadDrawnMatte(const std::filesystem::path& path);

/// What was done to a matte so that it lies on its picture.
struct MatteChange {
  bool turned = false;   ///< it lay as the picture is stored
  bool resized = false;  ///< it was smaller or larger, in the same shape
};

/// The matte at its picture's size.
/// @param orientation  of the picture's file, as EXIF counts
/// @param what         names matte and picture for messages, as in "locate: matte a.png of b.jpg"
/// @param change       may be null
/// @throws InputError  another shape, or less than an eighth of the size
Image8 PlacedMatte(Image8 matte, int width, int height, int orientation, const std::string& what,
                   MatteChange* change);

}  // namespace keypose
