// The frames of the finished animation.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Count, rate, area and volume of the last frames that interpolate made.
/// @throws UsageError  there are none yet
nlohmann::json FramesJson(Snapshot& snapshot);

/// Positions of all vertices of all frames: float32, in the order of the template's vertices.
/// @throws UsageError  there are none yet, or more than fit into 1 GiB
std::string FramePositions(Snapshot& snapshot);

}  // namespace keypose::studio
