// Second half of sfm: cameras from what the photographs show, by one strategy after the other until
// the evidence leaves no doubt.
#pragma once

#include <filesystem>

#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// One strategy after the other until one holds all photographs and the evidence is sure; else the
/// one for which the evidence is best. Coarse features come first, and fine ones where those leave
/// photographs out, hang on few points, or give doubtful cameras.
/// @param matched  set: what the photographs showed in the end
/// @return what the winner found and measured; its measurements are for the caller to report
/// @throws InputError  the photographs share so little that no strategy can succeed; said before
/// any is tried
StrategyResult FindCameras(const StrategyContext& context, const std::filesystem::path& scratch,
                           MatchedFeatures& matched);

}  // namespace keypose::reconstruct
