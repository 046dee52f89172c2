// First cameras of photographs before tripods, by the mat or disc that turns there with the figure.
#pragma once

#include <optional>

#include "reconstruct/sfm/print_check.h"
#include "reconstruct/sfm/strategy.h"

namespace keypose::reconstruct {

/// Where the plane that turns is in each tripod's pictures, which matches tell at any turn; how far
/// each tripod is from it, by matches between tripods; and how far it is turned in each photograph,
/// by its print. Paint that hardly matches does for this, and a scale that matches itself.
/// @return photographs whose print says how it is turned, without points; nothing where no tripod
///         shows such a plane
std::optional<Scene> CamerasOverTurningPrint(const StrategyContext& context,
                                             const PrintPictures& pictures,
                                             const MatchedFeatures& matched);

}  // namespace keypose::reconstruct
