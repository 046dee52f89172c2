#include "studio/routes/cameras_routes.h"

#include "core/values/errors.h"
#include "pipeline/run/opened_project.h"
#include "studio/project/camera_points.h"
#include "studio/project/changes.h"
#include "studio/project/films.h"
#include "studio/runs/children.h"

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

void CamerasRoutes::AddTo(RouteTable& table) {
  table.Get("/api/calibration",
            [this](const Question&) { return JsonAnswer(CameraPointsJson(project_.folder())); });
  table.Put("/api/calibration", [this](const Question& question) {
    return JsonAnswer(project_.WithFolder([&](const fs::path& folder) {
      SaveCameraPoints(folder, question.Json());
      return CameraPointsJson(folder);
    }));
  });
  table.Get("/api/calibration/picture", [this](const Question& question) {
    const int frame = WholeNumber(question.Get("frame", "0"), 0, kMostStills);
    const int width = WholeNumber(question.Get("width", "0"), 0, kWidestStill);
    const FrameSource still = StillOf(project_.folder(), question.Need("camera"));
    return PictureAnswer(FramePicture(project_.PictureFolder(), still, frame, width));
  });
  table.Post("/api/calibration/run",
             [this](const Question& question) { return Calibrate(question); });
  table.Post("/api/calibration/use", [this](const Question& question) {
    return JsonAnswer(project_.WithFolder([&](const fs::path& folder) {
      UseCalibration(folder, question.Json().at("shot"));
      return CameraPointsJson(folder);
    }));
  });
}

Answer CamerasRoutes::Calibrate(const Question& question) {
  const Alone alone(calibrating_);
  const json body = question.Json();
  if (project_.run().running()) throw LockedError("a run is at work; calibrate when it is done");
  const std::string revision = RevisionOf(project_.folder() / kPointsFile);
  std::vector<std::string> words = CalibrateFlags(
      project_.folder(), body.value("lenses", std::string()), body.value("square_mm", 22.0));
  words.insert(words.begin(), (pipeline::ProgramFolder() / "keypose-calibrate").string());
  const ChildResult result = RunChild(words, project_.folder(), kCalibrateSeconds);
  if (result.exit_code != 0) throw InputError(ErrorIn(result.output, result.exit_code));
  return JsonAnswer(project_.WithFolder([&](const fs::path& folder) {
    TakeCalibration(folder, revision);
    return CameraPointsJson(folder);
  }));
}

}  // namespace keypose::studio
