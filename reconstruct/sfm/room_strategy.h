// Cameras by all that moves with the figure in a room: the whole photographs where all stands
// still, else the part of them that the figure follows.
#pragma once

#include <filesystem>
#include <functional>

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Structure from motion with the verified matches of a database.
using PlaceByFiles = std::function<StrategyResult(const SfmFiles&, const MatchedFeatures&)>;

/// The cameras by what moves with the figure. Before a tripod what stays in place is left out. Else
/// whole photographs are placed; what does not fit these cameras is placed by itself, and of the
/// two the one counts whose cameras go round it: people turn the figure, or walk round it, to
/// photograph it from all sides.
/// @param matched  set to the features of the result
/// @return without views where the figure does not move as what was placed
StrategyResult PlaceBySurroundings(const StrategyContext& context,
                                   const std::filesystem::path& scratch, const PlaceByFiles& place,
                                   MatchedFeatures& matched);

}  // namespace keypose::reconstruct
