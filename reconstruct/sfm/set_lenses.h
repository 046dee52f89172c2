// The lenses of a set of photographs, before any adjustment: those of one size and one focal length
// share one.
#pragma once

#include <vector>

#include "core/io/pictures/image_set.h"
#include "core/values/camera.h"

namespace keypose::reconstruct {

struct SetLenses {
  std::vector<Camera> cameras;  ///< in the order of their first photographs
  std::vector<int> of_image;    ///< for each photograph the index of its camera
  bool focal_known = false;     ///< some photograph states its focal length
};

/// Photographs share a lens if they have one size, as written and as photographed, and focal
/// lengths that differ by less than a tenth of the smallest in that size (a focus that breathes
/// stays one lens); those without a focal length go with the most common one of their size. A lens
/// of fewer than three photographs, which could not be solved for, goes with the next longer or
/// shorter one of its size. The focal length is the median of its photographs', else that of the
/// other lenses relative to the size, else 1.2 times the longer side, which is COLMAP's first
/// guess.
SetLenses LensesOf(const ImageSet& set);

}  // namespace keypose::reconstruct
