// Cameras by all that stands still with the figure: whether a set has enough of it, and what the
// report says of it.
#pragma once

#include <filesystem>
#include <optional>

#include "reconstruct/sfm/strategy.h"
#include "reconstruct/surroundings/support_plane.h"

namespace keypose::reconstruct {

/// Whether neighbouring photographs share many places outside of the masks that do not stay where
/// they are in the picture. Looks at a few pairs spread over the set.
bool HasSurroundings(const StrategyContext& context, const std::filesystem::path& scratch);

/// Whether cameras by surroundings need no other strategy: nearly all photographs are placed, and
/// matches agree.
bool IsEnough(const StrategyContext& context, const StrategyResult& result);

/// Whether hardly any photograph is left to be placed by more features or another focal length.
bool HasNearlyAll(const StrategyContext& context, const StrategyResult& result);

/// Adds which share of the matches lies on the masks and around them, and what was left behind.
void MeasureSurroundings(const EvidenceCheck& check, const MatchedFeatures& matched,
                         StrategyResult& result);

/// The frame of a scene in a room: the plane under the figure is z = 0, the place under what the
/// cameras look at is the origin, the median distance of the cameras to that is 1.
Similarity3 LevelBySupport(const SupportPlane& support, const std::vector<View>& views);

}  // namespace keypose::reconstruct
