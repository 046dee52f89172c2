// Photographs that are upside down relative to the others, for example from a camera that was
// turned over and wrote no EXIF orientation.
#pragma once

#include <vector>

#include "core/values/image.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

/// For each image: 1 if it is upside down relative to most of those with matches, 0 if it is not,
/// -1 if no match decides.
///
/// For a pair, the matched positions about their means are compared in both orientations: as they
/// are, and rotated by 180 degrees. The clearest pairs connect all images (a spanning tree), so
/// that views from far above, which rotate gradually in the picture, are no problem. The smaller
/// group is assumed to be upside down.
/// @param pairs  verified matches
std::vector<int> UpsideDownByMatches(int images, const std::vector<PairPoints>& pairs);

/// The same by outlines, for images that matches do not decide: the share of each row of the
/// picture that the mask covers hardly changes while the table turns. Each mask is compared in both
/// orientations with the median of the others.
/// @param known  from UpsideDownByMatches; entries of -1 are decided, 0 where neither orientation
/// is clearly better
/// @param masks  1 channel, above 127 inside; empty where there is none
std::vector<int> UpsideDownByOutlines(std::vector<int> known, const std::vector<Image8>& masks);

}  // namespace keypose::reconstruct
