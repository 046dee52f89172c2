#include "synth/scores/motion_score.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/io/meshes/bvh_io.h"
#include "core/io/meshes/mesh_io.h"
#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/mask_overlap.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "synth/photographs/mask_fill.h"
#include "synth/worlds/performer.h"

namespace keypose::synth {
namespace {

namespace fs = std::filesystem;
using TrueJoints = std::vector<std::map<std::string, Eigen::Vector3d>>;

TrueJoints ReadJoints(const fs::path& path) {
  std::istringstream lines(ReadFile(path));
  std::string line;
  std::getline(lines, line);
  TrueJoints frames;
  while (std::getline(lines, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::size_t frame = 0;
    std::string name;
    Eigen::Vector3d x;
    if (!(words >> frame >> name >> x[0] >> x[1] >> x[2]) || frame > frames.size())
      throw InputError("synth: " + PrintableName(path) + " is not what `synth performance` writes");
    if (frame == frames.size()) frames.emplace_back();
    frames[frame][name] = x;
  }
  return frames;
}

/// Places of the joints in one frame, in one column, in the order of Performer::JointNames.
using JointPlaces = Eigen::VectorXd;

/// Mean length over joints and frames of second differences in time.
double MeanSecondDifference(const std::vector<JointPlaces>& frames) {
  double sum = 0;
  for (std::size_t f = 0; f + 2 < frames.size(); ++f)
    sum += (frames[f] - 2 * frames[f + 1] + frames[f + 2])
               .reshaped(3, frames[f].size() / 3)
               .colwise()
               .norm()
               .mean();
  return frames.size() > 2 ? sum / static_cast<double>(frames.size() - 2) : 0;
}

MotionClip ReadClip(const fs::path& path, int frames) {
  MotionClip clip = ReadBvh(path);
  if (clip.frame_count() != frames)
    throw InputError(
        fmt::format("synth: the motion has {} frames, its truth {}", clip.frame_count(), frames));
  return clip;
}

void ScoreJoints(const MotionScoreCommand& command, MotionScore* score) {
  const TrueJoints truth = ReadJoints(command.performance / "truth" / "joints.csv");
  const MotionClip clip = ReadClip(command.motion, SizeOf(truth));
  score->frames = SizeOf(truth);
  score->joint_means_m.assign(Performer::JointNames().size(), 0);
  int count = 0;
  const auto joint_count = static_cast<Eigen::Index>(Performer::JointNames().size());
  std::vector<JointPlaces> tracked(truth.size(), JointPlaces(3 * joint_count)), real = tracked;
  for (int f = 0; f < SizeOf(truth); ++f) {
    const std::vector<Rigid3> joints = JointFrames(clip, f);
    double worst = 0;
    for (std::size_t j = 0; j < Performer::JointNames().size(); ++j) {
      const std::string& name = Performer::JointNames()[j];
      const int joint = clip.Find(name);
      if (joint < 0) throw InputError("synth: the motion has no joint named " + name);
      const Eigen::Vector3d& p = joints[joint].translation;  // y up
      const auto place = 3 * static_cast<Eigen::Index>(j);
      tracked[f].segment<3>(place) = Eigen::Vector3d(p.x(), -p.z(), p.y());
      real[f].segment<3>(place) = truth[f].at(name);
      const double error = (tracked[f] - real[f]).segment<3>(place).norm();
      worst = std::max(worst, error);
      if (f < command.from) continue;
      score->joint_mean_m += error;
      score->joint_means_m[j] += error;
      ++count;
      if (error > score->joint_worst_m) {
        score->joint_worst_m = error;
        score->worst = fmt::format("{} in frame {}", name, f);
      }
    }
    score->frame_worst_m.push_back(worst);
  }
  const Trembling trembling = TremblingOf(tracked, real);
  score->second_difference = trembling.second_difference;
  score->trembling_m = trembling.trembling_m;
  score->joint_mean_m /= std::max(1, count);
  for (double& mean : score->joint_means_m) mean /= std::max(1, score->frames - command.from);
}

std::vector<double> FrameIoUs(const MotionScoreCommand& command, const std::vector<View>& views,
                              int frames) {
  std::vector<double> sums(static_cast<std::size_t>(frames), 0);
  ParallelFor(frames, [&](std::int64_t f) {
    const Mesh mesh = ReadMesh(command.frames / fmt::format("frame_{:04}.ply", f));
    for (const View& view : views) {
      const fs::path mask =
          command.performance / "truth" / "masks" / view.name / fmt::format("{:03}.png", f);
      sums[f] +=
          MaskIoU(ReadImage(mask, 1), FillMask(mesh.points, mesh.faces, view), 1) / SizeOf(views);
    }
  });
  return sums;
}

}  // namespace

Trembling TremblingOf(const std::vector<Eigen::VectorXd>& tracked,
                      const std::vector<Eigen::VectorXd>& truth) {
  std::vector<JointPlaces> errors;
  for (std::size_t f = 0; f < tracked.size(); ++f) errors.push_back(tracked[f] - truth[f]);
  const double real = MeanSecondDifference(truth);
  return {real > 0 ? MeanSecondDifference(tracked) / real : 0, MeanSecondDifference(errors)};
}

MotionScore ScoreMotion(const MotionScoreCommand& command) {
  MotionScore score;
  ScoreJoints(command, &score);
  const auto views = ReadRigCalibration(command.performance / "calibration.yml").views;
  const auto held_out =
      ReadRigCalibration(command.performance / "held_out" / "calibration.yml").views;
  const std::vector<double> seen = FrameIoUs(command, views, score.frames);
  const std::vector<double> unseen = FrameIoUs(command, held_out, score.frames);
  const int counted = std::max(1, score.frames - command.from);
  for (int f = command.from; f < score.frames; ++f) {
    score.iou_mean += seen[f] / counted;
    score.iou_held_out += unseen[f] / counted;
    score.iou_least = std::min(score.iou_least, seen[f]);
  }
  return score;
}

std::string ToJson(const MotionScore& score) {
  nlohmann::ordered_json json;
  json["frames"] = score.frames;
  json["joint_mean_mm"] = 1000 * score.joint_mean_m;
  json["joint_worst_mm"] = 1000 * score.joint_worst_m;
  json["worst"] = score.worst;
  json["iou_mean"] = score.iou_mean;
  json["iou_least"] = score.iou_least;
  json["iou_held_out"] = score.iou_held_out;
  json["second_difference"] = score.second_difference;
  json["trembling_mm"] = 1000 * score.trembling_m;
  for (std::size_t j = 0; j < score.joint_means_m.size(); ++j)
    json["joints_mm"][Performer::JointNames()[j]] = 1000 * score.joint_means_m[j];
  json["frame_worst_mm"] = nlohmann::json::array();
  for (const double worst : score.frame_worst_m)
    json["frame_worst_mm"].push_back(std::round(10000 * worst) / 10);
  return json.dump(1) + "\n";
}

}  // namespace keypose::synth
