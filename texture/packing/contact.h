// How outlines in the unit square touch: what must move so that they keep their distance.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::texture {

/// Directions that set outlines apart.
struct Contacts {
  std::vector<UvsX2> push;  ///< per outline, a row per vertex: the move that resolves its contacts,
                            ///< zero where it has none
  double least_gap = 0;  ///< smallest distance between two outlines, or twice that to the border;
                         ///< negative: depth of an overlap
};

/// @param rims   simple polygons, counter-clockwise
/// @param gap    wanted distance between any two, and half of it to the border of the unit square
/// @param reach  how deep overlaps are still recognised, > gap; least_gap is at most this
/// Cost: near linear.
/// Same bits for any thread count. Overlaps of one outline with itself push but do not count for
/// least_gap.
Contacts FindContacts(const std::vector<UvsX2>& rims, double gap, double reach);

/// Whether edges of two different outlines cross, which vertices alone do not always show. In
/// floating point.
bool AnyCross(const std::vector<UvsX2>& rims);

}  // namespace keypose::texture
