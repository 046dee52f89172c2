// What the stage `track` reads: the shot, its cameras in metres, and silhouettes frame by frame.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "core/stage/stage.h"
#include "motion/tracking/mask_runs.h"
#include "motion/tracking/rig_checks.h"
#include "views/shot/given_masks.h"
#include "views/shot/shot.h"

namespace keypose::motion {

struct TrackInputOptions {
  std::string cameras;      ///< names that are used, comma-separated; empty: all
  std::string up = "auto";  ///< auto, x, y, z, -x, -y, -z: the world's axis that points up
  double height_m = 0;      ///< of the actor; 0: not known
  int sync_frames = 10;     ///< largest offset between clocks that is looked for; 0: none
  int at_frame = 0;         ///< the frame in which cameras are compared
  ClockWish clocks;         ///< of films
};

/// A shot whose cameras are matched to a calibration.
class TrackInput {
 public:
  /// Opens the shot, reads the calibration, compares both.
  /// @throws InputError  a camera without calibration; sizes differ; cameras that do not see one
  /// place; says which and what to do
  TrackInput(StageContext& stage, const std::filesystem::path& shot_folder,
             const TrackInputOptions& options);
  ~TrackInput();

  int frames() const { return frames_; }
  /// Of the films, by cameras, where they are not as the time stamps say.
  const std::map<std::string, FilmClock>& film_clocks() const { return shot_.join.clocks; }
  double frames_per_second() const { return shot_.frames_per_second; }
  double metres_per_unit() const { return metres_per_unit_; }
  const Eigen::Quaterniond& up_from_world() const { return up_from_world_; }
  const std::vector<SilhouetteCamera>& cameras() const { return cameras_; }
  const std::vector<int>& used() const { return used_; }  ///< cameras that are fitted to
  const std::vector<int>& compared() const {
    return compared_;
  }  ///< cameras that are only compared
  const CoarseHull& hull() const { return hull_; }
  const std::vector<int>& offsets() const { return offsets_; }  ///< per camera [frames]

  /// Silhouettes of the used cameras in frames [first, first + count); negative steps go backwards.
  std::vector<std::vector<Silhouette>> Read(int first, int count, int step = 1);
  /// Turns the used cameras about their centres, by rotation vectors in world [rad].
  void TurnCameras(const std::vector<Eigen::Vector3d>& turns);
  /// One camera's mask in a frame, at full size; and its picture, RGB (the mask where there is
  /// none).
  Image8 Mask(int camera, int frame);
  Image8 Picture(int camera, int frame);

 private:
  void Match(StageContext& stage, const TrackInputOptions& options);
  /// A picture that tells a film's size and black borders: of the film, else the mask.
  Image8 Shown(int camera);
  void CountFrames(StageContext& stage);
  void OpenMasks(StageContext& stage);
  void FindUnit(StageContext& stage, const TrackInputOptions& options);
  void Compare(StageContext& stage, int frame);
  void FindClocks(StageContext& stage, const TrackInputOptions& options);
  void MakeCameras();
  Image8 ReducedMask(int camera, int frame);

  /// Reduced masks that were read before: several passes go over the frames.
  struct KnownMasks {
    std::unordered_map<int, MaskRuns> frames;
    std::int64_t bytes = 0;
  };

  Shot shot_;
  std::vector<View> views_;  // metres
  std::vector<std::unique_ptr<GivenMasks>> masks_;
  std::vector<std::unique_ptr<FrameReader>> pictures_;
  std::vector<SilhouetteCamera> cameras_;
  std::vector<KnownMasks> known_;  // per camera, as the reduced pictures of cameras_
  std::vector<int> used_, compared_, offsets_;
  Eigen::Quaterniond up_from_world_ = Eigen::Quaterniond::Identity();
  double metres_per_unit_ = 0;
  std::optional<Eigen::Vector3d> calibrated_up_;
  CoarseHull hull_;
  int frames_ = 0;
};

}  // namespace keypose::motion
