// Proves that a texture layout has no flips and no overlaps, and measures its stretch.
#pragma once

#include "core/values/mesh.h"

namespace keypose::texture {

struct AtlasFaults {
  int outside = 0;    ///< UV vertices not in [0,1] or not on the grid of 2^-40
  int flipped = 0;    ///< triangles that are not strictly counter-clockwise
  int not_disks = 0;  ///< charts with other than one simple boundary loop
  /// pairs of chart boundary edges that intersect, except in a shared corner
  int crossings = 0;
  int nested = 0;  ///< charts that lie inside another one
  bool none() const { return outside + flipped + not_disks + crossings + nested == 0; }
};

/// Exact, in integers. A map of a disk is injective when no triangle flips and its boundary does
/// not intersect itself; disks do not overlap if their boundaries do not intersect and they are not
/// nested. So without faults no two triangles overlap.
/// @param mesh  with UVs
AtlasFaults FindAtlasFaults(const Mesh& mesh);

/// UVs rounded to multiples of 2^-40, which FindAtlasFaults requires and every file format with
/// doubles preserves.
UvsX2 OnGrid(const UvsX2& uvs);

/// Stretch from the texture to the surface, scaled so that an atlas of uniform density has 1.
struct AtlasStretch {
  double l2 = 0, linf = 0;                       ///< Sander, Snyder, Gortler, Hoppe, SIGGRAPH 2001
  double conformal_mean = 0, conformal_p99 = 0;  ///< larger over smaller singular value, by area
  double area_deviation = 0;  ///< mean of |texture area / surface area over its mean - 1|, by area
  double utilisation = 0;     ///< share of the unit square that triangles cover
};
AtlasStretch MeasureAtlasStretch(const Mesh& mesh);

}  // namespace keypose::texture
