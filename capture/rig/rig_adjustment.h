// All corners of all boards in all cameras, adjusted together.
#pragma once

#include <map>
#include <vector>

#include "capture/rig/board_sighting.h"
#include "core/values/camera.h"

namespace keypose::capture {

/// Moves lenses, cameras and boards to the least squared distances of the corners, with Huber's
/// loss at 1 px. Views must have good starts. The views' frame may drift by a rigid motion.
/// @param fixed_lenses      lenses stay as they are
/// @param world_from_board  per frame
/// @throws SolverError  it does not converge
void AdjustRig(const std::vector<BoardSighting>& sightings, const BoardLayout& board,
               bool fixed_lenses, std::vector<View>* views,
               std::map<int, Rigid3>* world_from_board);

}  // namespace keypose::capture
