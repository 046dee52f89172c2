// `keypose synth performance`: a filmed performance with its truth, as the stage `track` takes it.
#pragma once

#include <filesystem>
#include <string>

#include "core/values/progress.h"
#include "synth/worlds/performer.h"

namespace keypose::synth {

struct PerformanceCommand {
  std::filesystem::path output;
  std::filesystem::path bvh;       ///< a clip of the CMU database; empty: a motion of our own
  int first_frame = 0, every = 4;  ///< of the clip: 120 frames a second become 30
  int frames = 156;
  int cameras = 8;
  int size_px = 1000;   ///< pictures are square
  double noise_px = 2;  ///< of the masks' outlines
  /// the film begins with 6 frames with arms and legs apart and 18 on the way into the motion
  bool start_pose = true;
  bool pictures = true;  ///< colour pictures too, with a floor and shadows on it
  /// the actor's true mesh in each frame too, with vertices so far apart [m]; 0: none
  double mesh_spacing_m = 0;
  /// an arm that is missing from all masks for a time: first and last frame; none when equal
  int hidden_from = 0, hidden_to = 0;
  PerformerOptions performer;
  int jpeg_quality = 92;

  std::vector<std::string> Problems() const;
};

/// Writes into `output`:
///
/// - shot/masks/cam1/000.png ..., shot/cam1/000.jpg ..., shot/background/cam1.jpg
/// - calibration.yml: the cameras, metres, z up
/// - held_out/cam9/..., held_out/calibration.yml: one more camera, which the shot lacks
/// - truth/masks/cam1/000.png ...: without noise, also of the held-out camera
/// - truth/frames/frame_0000.ply ..., distortion.json, where a spacing is given: the actor's mesh
/// - truth/joints.csv: frame, joint, x, y, z [m]; truth/motion.bvh: the motion as filmed, metres
/// @return one line about the written files
/// @throws UsageError, InputError, DiskError
std::string RunPerformance(const PerformanceCommand& command, Progress* progress = nullptr);

/// The cameras: on a ring about the place where the actor moves, at changing heights.
std::vector<View> PerformanceCameras(int cameras, int size_px, double reach_m);

}  // namespace keypose::synth
