// Photographs that stand on their heads beside the others, such as those of a camera that was
// turned over and wrote no EXIF orientation.
#pragma once

#include <vector>

#include "core/image.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

/// For each image 1 where it is upside down beside most of those that matches tie it to, 0 where it
/// is not, -1 where no match tells.
///
/// Of a pair, the matched places about their middle are scored for both orientations: as they are,
/// and turned by 180 degrees. The clearest pairs join all images (a spanning tree), so that views
/// from far above, which turn in the picture by and by, are no obstacle. The smaller part is taken
/// to be upside down.
/// @param pairs  verified matches
std::vector<int> UpsideDownByMatches(int images, const std::vector<PairPoints>& pairs);

/// The same by outlines, for what matches leave open: how much of each row of the picture the mask
/// fills hardly changes while the table turns. Each mask is scored both ways against the median of
/// the others.
/// @param known  as UpsideDownByMatches; entries of -1 are decided, 0 where neither way is clearly
/// better
/// @param masks  1 channel, above 127 inside; empty where there is none
std::vector<int> UpsideDownByOutlines(std::vector<int> known, const std::vector<Image8>& masks);

}  // namespace keypose::reconstruct
