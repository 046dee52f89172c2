// The frames of the finished animation, or of a shot of a performance.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "studio/project/snapshot.h"

namespace keypose::studio {

/// Count, rate, area and volume of the last frames; of a shot also its colours (frame_colours.h).
/// @param shot  "" for the animation between the keys
/// @throws UsageError  there are none yet
nlohmann::json FramesJson(Snapshot& snapshot, const std::string& shot);

/// Positions of all vertices of all frames: float32, in the order of the template's vertices.
/// @throws UsageError  there are none yet, or more than fit into 1 GiB
std::string FramePositions(Snapshot& snapshot, const std::string& shot);

/// The first frame as a mesh (mesh_bytes.h), of a shot with the layout of its textures; the others
/// have its faces.
/// @throws UsageError  there are none yet
std::string FirstFrame(Snapshot& snapshot, const std::string& shot);

}  // namespace keypose::studio
