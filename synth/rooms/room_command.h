// `keypose synth room`: photographs of a generated room, with their truth.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/progress.h"
#include "synth/rooms/room_plan.h"

namespace keypose::synth {

struct RoomCommand {
  std::filesystem::path output;
  RoomOptions room;
  int jpeg_quality = 93;
};

/// Writes photos/figure/IMG_0001.jpg, ... and truth/figure/ below `output`:
///
/// - cameras/: exact cameras in the figure's frame [m], which turns with the mat; cameras_of_room/:
///   the same in the frame of what stands still
/// - masks/NAME.png: 255 where the figure alone is seen; parts/NAME.png: values of Part
/// - surface.ply, outer.ply, landmarks.json, world.json: as `synth photos` writes them
/// - room.json: kind, lenses, what it stands on, and for each photograph turn, lens, tripod, a
///   place on the figure, a line on another thing
///
/// Photographs of an earlier room in that folder are replaced.
/// @return a line for the console
/// @throws UsageError  a fault in the options, photographs that synth did not make
/// @throws DiskError
std::string RunRoom(const RoomCommand& command, Progress* progress);

}  // namespace keypose::synth
