// A part of the figure that several masks show and the mesh lacks, and the masks that leave it out.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::report {

/// A mask, and what the mesh covers of the same picture. Both have the camera's size.
struct CoveredMask {
  View view;
  Image8 mask;     ///< 1 channel, object where >= 128
  Image8 covered;  ///< 1 channel, 255 where the mesh is
};

/// Views by their names.
struct MissingPart {
  double largest = 0;  ///< share of the figure in the picture where most is missing
  /// views whose mask shows more than kMissingLook of the figure that the mesh lacks, most first
  std::vector<std::string> shown_by;
  /// views in whose masks most of it is outside, at the depth that fewest masks contradict; most
  /// first. Empty: the masks agree that it is there
  std::vector<std::string> left_out_by;
};

/// @param points  of the mesh: the missing part is looked for around them
/// @return without views if fewer than two show one: a single mask may be wrong
/// Same bits for any thread count.
MissingPart FindMissingPart(const std::vector<CoveredMask>& views, const PointsX3& points);

}  // namespace keypose::report
