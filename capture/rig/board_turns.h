// Cameras joined by boards that they saw together, also by checkerboards that look the same after a
// half turn.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "capture/rig/board_sighting.h"
#include "core/values/camera.h"

namespace keypose::capture {

/// Boards as each camera sees them: [camera][frame].
using BoardPoses = std::vector<std::map<int, Rigid3>>;

/// Camera b from camera a, by boards that both saw: the motion that the others differ least from,
/// each board turned as fits best.
/// @param turns  ways to turn the board that nobody can tell apart: 1, 2 or 4
/// @return empty: no board in common, or boards that leave two motions possible
std::optional<Rigid3> CameraBetween(const std::map<int, Rigid3>& a, const std::map<int, Rigid3>& b,
                                    int turns);

/// Turns all cameras' boards of a frame alike, once cameras are placed: poses, and the corners'
/// numbers.
void SettleTurns(int turns, const std::vector<View>& views, const BoardLayout& board,
                 BoardPoses* poses, std::vector<BoardSighting>* sightings);

}  // namespace keypose::capture
