// Masks that a person gives, brought over their photographs: turned, enlarged, the right way round.
#pragma once

#include <string>

#include "core/values/image.h"

namespace keypose::capture {

/// Where a mask belongs.
struct MaskPlace {
  int width = 0, height = 0;     ///< of the photograph, after its EXIF orientation is applied
  int orientation = 1;           ///< of the photograph, as EXIF counts
  std::string mask, photograph;  ///< names, for messages
};

/// What was done to a mask so that it lies on its photograph.
struct MaskChange {
  bool turned = false;    ///< it lay as the photograph is stored
  bool enlarged = false;  ///< it was smaller or larger, in the same shape
};

/// The mask at the photograph's size, upright.
/// @param mask    H x W, 255 or 0
/// @param change  may be null
/// @throws InputError  another shape, or less than an eighth of the size
Image8 PlacedMask(Image8 mask, const MaskPlace& place, MaskChange* change);

enum class MaskSide {
  kFigure,        ///< white is the figure
  kSurroundings,  ///< white is all but the figure
  kNothing,       ///< black all over
};
/// Surroundings cover the border (see CoversBorder).
/// @param mask  255 or 0
MaskSide SideOf(const Image8& mask);

/// How much brightness changes across the border of a mask: grey levels on the mean. 0 without a
/// border.
/// @param grey  H x W
/// @param mask  of the same size
double BorderContrast(const Image8& grey, const Image8& mask);

}  // namespace keypose::capture
