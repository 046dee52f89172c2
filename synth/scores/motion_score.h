// `keypose synth score-motion`: a tracked performance compared with its truth.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace keypose::synth {

struct MotionScoreCommand {
  std::filesystem::path performance;  ///< folder that `synth performance` wrote
  std::filesystem::path frames;       ///< frame_0000.ply ... of `track`
  std::filesystem::path motion;       ///< .bvh of `track`
  int from = 0;                       ///< first frame that counts
};

struct MotionScore {
  int frames = 0;
  double joint_mean_m = 0, joint_worst_m = 0;
  std::string worst;                   ///< joint and frame
  double iou_mean = 0, iou_least = 1;  ///< to the masks without noise, of the shot's cameras
  double iou_held_out = 0;             ///< in the camera that the shot lacks
  /// mean second difference in time of the joints' places, over that of the true ones: above 1 they
  /// tremble
  double second_difference = 0;
  /// mean second difference of the joints' errors [m/frame^2]: what trembles or is smeared
  double trembling_m = 0;
  std::vector<double> joint_means_m;  ///< by Performer::JointNames
  std::vector<double> frame_worst_m;  ///< by frame: the joint that is farthest off
};

struct Trembling {
  double second_difference = 0, trembling_m = 0;  ///< as in MotionScore; 0: fewer than 3 frames
};
/// @param tracked,truth  by frame, at least one: places of the joints, three numbers [m] a joint
Trembling TremblingOf(const std::vector<Eigen::VectorXd>& tracked,
                      const std::vector<Eigen::VectorXd>& truth);

/// @throws InputError  files missing, or of different length
MotionScore ScoreMotion(const MotionScoreCommand& command);
/// As JSON.
std::string ToJson(const MotionScore& score);

}  // namespace keypose::synth
