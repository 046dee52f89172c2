// Second half of sfm: cameras from the matched features, by one strategy after the other until the
// evidence is sure.
#pragma once

#include <filesystem>

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Tries one strategy after the other until one places all photographs with sure evidence; else
/// returns the one with the best evidence. Coarse features are tried first. Fine ones follow if
/// photographs are missing, if there are few points, or if the cameras are doubtful.
/// @param matched  set to the features that were used last
/// @return the best result with its measurements, which the caller reports
/// @throws InputError  the photographs overlap so little that no strategy can succeed; thrown
/// before any is tried
StrategyResult FindCameras(const StrategyContext& context, const std::filesystem::path& scratch,
                           MatchedFeatures& matched);

}  // namespace keypose::reconstruct
