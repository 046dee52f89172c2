// `keypose synth score-room`: compares what was made of a room's photographs with its truth.
#pragma once

#include <filesystem>
#include <string>

namespace keypose::synth {

struct RoomScoreCommand {
  std::filesystem::path truth;  ///< truth/figure that `synth room` wrote
  /// COLMAP model; folder of masks NAME.png; mesh in the model's frame; empty: not scored
  std::filesystem::path model, masks, mesh;
};

/// @return JSON: cameras (total, placed, good, wrong, missing, agree with the figure's motion and
/// with the still room), masks (median, worst, overlap of each), base (ScoreBase)
/// @throws InputError  a file missing or malformed, a mesh without a model
std::string RunRoomScore(const RoomScoreCommand& command);

}  // namespace keypose::synth
