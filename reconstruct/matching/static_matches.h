// Removes matches on the static background of a turntable.
#pragma once

#include <utility>
#include <vector>

#include "reconstruct/matching/colmap_database.h"

namespace keypose::reconstruct {

/// Removes matches that do not move between two photographs, if there are so many that the camera
/// must have been fixed: the background of a turntable, where masks are missing or include it.
/// Those matches would place all cameras at the same position.
///
/// A match is static when it moves by less than a thousandth of the picture's longer side or 1 px.
/// Static matches are removed if there are at least 8 and more than matches that move by one to
/// three times that limit. Displacements of a turning object are distributed smoothly, and then
/// that ring, with eight times the area, has more matches.
/// @return number of removed matches
int RejectStaticMatches(const Features& first, const Features& second, int longer_side_px,
                        std::vector<std::pair<std::uint32_t, std::uint32_t>>& matches);

}  // namespace keypose::reconstruct
