// The set without the character, from frames in which it moves away.
#pragma once

#include <vector>

#include "core/values/image.h"

namespace keypose::composite {

/// A filmed frame, and where it shows the set.
struct PlateFrame {
  ImageF light;  ///< RGB, linear, of the plate's exposure
  Image8 away;   ///< 1 channel: > 127 where the character is, or near
  ImageF kept;   ///< 1 channel: share of light that its shadow leaves; empty: not known
};

struct CleanPlate {
  ImageF light;          ///< RGB, linear
  ImageF grain_lacking;  ///< 1 channel, 0 to 1: how much of the grain's variance was averaged away
  int hidden = 0;        ///< pixels that no frame shows
  int given = 0;         ///< of those, taken from a given plate
  int inpainted = 0;     ///< of those, painted in from their surroundings
};

/// What light may be: of stored pictures 0 to 1, of a scene anything.
enum PlateLight { kBounded, kUnbounded };

/// For each pixel the mean of the frames that show it, without those that differ from the median by
/// more than grain does. Where shadows are not known, the brightest frames count: shadows darken.
/// A pixel that no frame shows comes from the given plate, else it is painted in.
///
/// @param given  linear light of the same exposure; empty: none
/// @throws InputError  no frame and no given plate, or sizes that differ
/// Same bits for any thread count.
/// Source of the inpainting: Telea, Journal of Graphics Tools, 2004, in OpenCV.
CleanPlate MakeCleanPlate(const std::vector<PlateFrame>& frames, const ImageF& given,
                          PlateLight bounds = kBounded);

}  // namespace keypose::composite
