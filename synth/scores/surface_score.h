// `keypose synth score-surface`: the surface of a performance compared with the true one.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace keypose::synth {

struct SurfaceScoreCommand {
  std::filesystem::path performance;  ///< folder that `synth performance --meshes` wrote
  std::filesystem::path frames;       ///< frame_0000.ply ... of the moving mesh
  int every = 1;                      ///< only every n-th frame is measured
};

struct MovingSurfaceScore {
  int frames = 0;  ///< measured
  /// distance of the true surface's points from the mesh [m], over all of them
  double mean_m = 0, p95_m = 0;
  double worst_frame_mean_m = 0;
  int worst_frame = 0;
  double iou_held_out = 0, iou_held_out_least = 1;  ///< in the camera that the shot lacks
  /// mean length of the vertices' second difference in time, over that of the true surface's
  double second_difference = 0;
};

/// @throws InputError  files missing, or of different length
MovingSurfaceScore ScoreMovingSurface(const SurfaceScoreCommand& command);
/// As JSON.
std::string ToJson(const MovingSurfaceScore& score);

}  // namespace keypose::synth
