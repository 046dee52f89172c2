// Contacts of outlines in the unit square, and displacements that restore their distance.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::texture {

/// Directions that separate outlines.
struct Contacts {
  std::vector<UvsX2> push;  ///< per outline, one row per vertex: the displacement that resolves its
                            ///< contacts, zero without contacts
  double least_gap = 0;  ///< smallest distance between two outlines, or twice that to the border;
                         ///< negative: depth of an overlap
};

/// @param rims   simple polygons, counter-clockwise
/// @param gap    wanted distance between any two, and half of it to the border of the unit square
/// @param reach  largest depth of detected overlaps, > gap; least_gap is at most this
/// Cost: near linear.
/// Same bits for any thread count. Overlaps of an outline with itself give displacements but do not
/// count for least_gap.
Contacts FindContacts(const std::vector<UvsX2>& rims, double gap, double reach);

/// Whether edges of two different outlines cross, which vertices alone do not always reveal. In
/// floating point.
bool AnyCross(const std::vector<UvsX2>& rims);

}  // namespace keypose::texture
