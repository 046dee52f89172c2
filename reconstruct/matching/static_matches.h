// Matches on what does not turn with the table.
#pragma once

#include <utility>
#include <vector>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// Takes away matches that stay in place between two photographs, when there are so many of them
/// that the camera must have stood still: the background of a turntable, where masks are missing or
/// let it through. It would hold the cameras together in one place.
///
/// A match stays in place when it moves by less than a thousandth of the picture's longer side or 1
/// px. They go when they are 8 or more and outnumber the matches that move by one to three times
/// that: places of a turning object spread smoothly over displacements, and then the ring of eight
/// times the area holds more.
/// @return how many were taken away
int RejectStaticMatches(const Features& first, const Features& second, int longer_side_px,
                        std::vector<std::pair<std::uint32_t, std::uint32_t>>& matches);

}  // namespace keypose::reconstruct
