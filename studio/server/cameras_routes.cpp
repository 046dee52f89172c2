// The cameras of a performance, calibrated by points of known place.
#include <atomic>

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/camera_points.h"
#include "studio/project/changes.h"
#include "studio/project/films.h"
#include "studio/runs/children.h"
#include "studio/server/routes.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kCalibrateSeconds = 1800;  // hundreds of large pictures of boards
constexpr int kMostStills = 1'000'000'000, kWidestStill = 100'000;

/// Held while something is at work that must not be twice.
class Alone {
 public:
  /// @throws LockedError  it is at work
  explicit Alone(std::atomic<bool>& busy) : busy_(busy) {
    if (busy_.exchange(true)) throw LockedError("the cameras are being calibrated already");
  }
  ~Alone() { busy_ = false; }
  Alone(const Alone&) = delete;
  Alone& operator=(const Alone&) = delete;

 private:
  std::atomic<bool>& busy_;
};

}  // namespace

// None of them asks for the plan: there is none before the cameras are calibrated.
void Routes::AddCameras() {
  Add("GET", "/api/calibration",
      [this](const Question&) { return JsonAnswer(CameraPointsJson(folder_)); });
  Add("PUT", "/api/calibration", [this](const Question& question) {
    const std::lock_guard<std::mutex> lock(mutex_);
    SaveCameraPoints(folder_, question.Json());
    return JsonAnswer(CameraPointsJson(folder_));
  });
  Add("GET", "/api/calibration/picture", [this](const Question& question) {
    const int frame = WholeNumber(question.Get("frame", "0"), 0, kMostStills);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestStill);
    const FrameSource still = StillOf(folder_, question.Need("camera"));
    return PictureAnswer(FramePicture(PictureFolder(), still, frame, width));
  });
  Add("POST", "/api/calibration/run",
      [this](const Question& question) { return Calibrate(question); });
  Add("POST", "/api/calibration/use", [this](const Question& question) {
    const std::lock_guard<std::mutex> lock(mutex_);
    UseCalibration(folder_, question.Json().at("shot"));
    return JsonAnswer(CameraPointsJson(folder_));
  });
}

Answer Routes::Calibrate(const Question& question) {
  static std::atomic<bool> busy = false;
  const Alone alone(busy);
  const json body = question.Json();
  if (run_->running()) throw LockedError("a run is at work; calibrate when it is done");
  const std::string revision = RevisionOf(folder_ / kPointsFile);
  std::vector<std::string> words =
      CalibrateFlags(folder_, body.value("lenses", std::string()), body.value("square_mm", 22.0));
  words.insert(words.begin(), (pipeline::ProgramFolder() / "keypose-calibrate").string());
  const ChildResult result = RunChild(words, folder_, kCalibrateSeconds);
  if (result.exit_code != 0) throw InputError(ErrorIn(result.output, result.exit_code));
  const std::lock_guard<std::mutex> lock(mutex_);
  TakeCalibration(folder_, revision);
  return JsonAnswer(CameraPointsJson(folder_));
}

}  // namespace keypose::studio
