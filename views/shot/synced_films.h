// The films of a shot beside a calibration and a motion: what each camera shows in each frame.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/stage/stage.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "views/shot/given_masks.h"
#include "views/shot/shot.h"

namespace keypose {

/// The inputs of a stage that looks at a moving mesh in films: `frames` and `layout`, which it
/// reads itself, and those that SyncedFilms opens.
std::vector<Port> MovingMeshPorts();

/// What a stage that reads films says of itself and of them.
struct FilmsRequest {
  std::string stage;    ///< its name, for messages
  std::string done;     ///< what it does with a frame, as in "painted"
  std::string cameras;  ///< names that are used, comma-separated; empty: all
  int frames = 0;       ///< of the motion
  bool need_masks = false;
};

/// What cameras filmed in one frame, one entry per camera; empty: nothing of this frame.
struct FilmedPictures {
  std::vector<Image8> pictures, masks;
};

class SyncedFilms {
 public:
  /// Opens what the stage's ports `video`, `masks`, `calibration` and `clocks` name (masks and
  /// clocks may be missing), and matches cameras to the calibration. Warns of short films.
  /// @throws InputError  a camera without film, mask (if needed) or calibration; pictures of other
  /// shapes; clocks that are no JSON; no frame in common. Says which and what to do
  SyncedFilms(StageContext& stage, const FilmsRequest& request);
  ~SyncedFilms();
  SyncedFilms(SyncedFilms&&) noexcept;

  const std::vector<View>& views() const { return views_; }     ///< for pictures of the films' size
  double frames_per_second() const { return rate_; }            ///< of the videos; 0: not known
  FilmedPictures Read(int frame) { return Read(frame, true); }  ///< cameras side by side
  FilmedPictures ReadMasks(int frame) { return Read(frame, false); }

 private:
  FilmedPictures Read(int frame, bool pictures);
  void Open(StageContext& stage);
  nlohmann::json ClocksJson(StageContext& stage) const;
  std::string ClocksName(StageContext& stage) const;
  ClockWish ReadFilmClocks(StageContext& stage) const;  // of their time stamps, before frames
  void ReadClocks(StageContext& stage);
  void CheckLengths(StageContext& stage);
  void CheckSizes(StageContext& stage);

  struct CameraFilm {
    ShotCamera files;
    std::unique_ptr<FrameReader> pictures;
    std::unique_ptr<GivenMasks> masks;  // may be null
    int offset = 0;                     // frame f of the motion is frame f + offset
  };
  FilmsRequest request_;
  std::vector<View> views_;
  std::optional<Eigen::Vector3d> up_;  // of the calibration's world, where it says so
  std::vector<CameraFilm> films_;
  double rate_ = 0;
};

}  // namespace keypose
