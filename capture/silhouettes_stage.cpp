// keypose-silhouettes: masks of an actor in the films of fixed cameras, against pictures of the
// empty set, or by what moves where there are none.
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include "capture/film_silhouettes.h"
#include "capture/pictures/working_image.h"
#include "capture/salience/salience_network.h"
#include "capture/segmentation/masking.h"
#include "capture/silhouettes_options.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/png_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/stage/stage.h"
#include "core/values/errors.h"
#include "core/values/figure_strokes.h"
#include "core/values/size_of.h"
#include "views/shot/shot.h"
#include "views/shot/shot_views.h"

namespace keypose::capture {
namespace {

constexpr int kTogether = 24;  // frames that are segmented as one set

StageSpec Spec() {
  StageSpec spec;
  spec.name = "silhouettes";
  spec.version = "7";
  spec.summary = "Masks of an actor in films of fixed cameras, with or without the empty set.";
  spec.title = "Masks of the films";
  spec.inputs = {
      {"video", "folder",
       "one folder of numbered pictures, or one video, for each camera, and background/CAMERA.jpg "
       "where there is a picture of the empty set",
       "", false, false},
      {"calibration", "path",
       "the cameras, to compare their masks in space; for films without the empty set", "", true,
       false}};
  spec.outputs = {
      {"masked", "folder", "masks/CAMERA/000.png ..., rate.json", "masked", false, false}};
  spec.memory_gib = 2;
  spec.shared_files = {kSalienceFile};
  return spec;
}

/// One camera's film, a few frames at a time.
class CameraMasks {
 public:
  CameraMasks(const ShotCamera& camera, const SilhouettesOptions& options,
              const std::filesystem::path& folder)
      : camera_(camera), reader_(camera.pictures), folder_(folder) {
    masking_.working_px = options.mask_px;
    masking_.clean_plate_difference = options.clean_plate_difference;
    plate_ = WorkingImage(ReadImage(camera.plate, 3), masking_.working_px);
    std::filesystem::create_directories(folder);
  }

  /// @return frames in which nothing was found
  int Write(int first, int count) {
    std::vector<Image8> pictures, small;
    for (int f = first; f < first + count; ++f) {
      pictures.push_back(reader_.Read(f, 3));
      small.push_back(WorkingImage(pictures.back(), masking_.working_px));
      if (small.back().width != plate_.width || small.back().height != plate_.height)
        throw InputError("silhouettes: background and film of camera " + camera_.name +
                         " have pictures of different shape");
    }
    const std::vector<Image8> masks = SegmentSet(small, plate_, {}, masking_);
    std::vector<int> empty(masks.size()), full(masks.size());
    ParallelFor(count, [&](std::int64_t i) {
      const Image8 mask = RefinedMask(pictures[i], masks[i]);
      empty[i] = MaskFraction(mask) == 0;
      full[i] = MaskFraction(mask) > kNearlyAll;
      char name[32];
      std::snprintf(name, sizeof name, "%03d.png", first + static_cast<int>(i));
      WriteMaskPng(folder_ / name, mask);
    });
    int sum = 0;
    for (const int e : empty) sum += e;
    for (const int f : full) full_ += f;
    return sum;
  }

  /// What is wrong with the plate, if most masks are nearly the whole picture; else empty.
  std::string Warning() const {
    if (2 * full_ <= camera_.frames()) return "";
    return fmt::format(
        "camera {}: {} of its {} masks are nearly the whole picture, since the film differs from "
        "its plate {} everywhere (other light or exposure, or a film with few colours, such as a "
        "GIF); make the plate with the film and in its format, or leave it out: then the actor is "
        "found by what moves",
        camera_.name, full_, camera_.frames(), PrintableName(camera_.plate.filename()));
  }

 private:
  static constexpr double kNearlyAll = 0.9;

  const ShotCamera& camera_;
  FrameReader reader_;
  std::filesystem::path folder_;
  MaskOptions masking_;
  Image8 plate_;
  int full_ = 0;  ///< masks of nearly the whole picture
};

/// The cameras with a picture of the empty set, or those without.
std::vector<ShotCamera> Cameras(const Shot& shot, bool with_plate) {
  std::vector<ShotCamera> cameras;
  for (const ShotCamera& camera : shot.cameras) {
    if (camera.pictures.empty())
      throw InputError("silhouettes: camera " + camera.name + " has no pictures");
    if (camera.plate.empty() != with_plate) cameras.push_back(camera);
  }
  return cameras;
}

/// @return frames in which nothing was found
int WriteByPlates(StageContext& stage, const std::vector<ShotCamera>& cameras,
                  const SilhouettesOptions& options, const std::filesystem::path& out,
                  Progress* progress) {
  int done = 0, empty = 0;
  for (const ShotCamera& camera : cameras) {
    CameraMasks masks(camera, options, out / camera.name);
    for (int f = 0; f < camera.frames(); f += kTogether) {
      if (stage.progress() && stage.progress()->cancelled()) throw Cancelled();
      empty += masks.Write(f, std::min(kTogether, camera.frames() - f));
      ReportProgress(progress, (done + static_cast<double>(f) / camera.frames()) / SizeOf(cameras),
                     camera.name);
    }
    if (const std::string warning = masks.Warning(); !warning.empty()) stage.Warn(warning);
    ++done;
  }
  return empty;
}

void Run(StageContext& stage, const SilhouettesOptions& options) {
  Shot shot = OpenShot(stage.Input("video"));
  for (const std::string& note : shot.join.notes) stage.Note(note);
  if (stage.Has("calibration"))
    LeaveOutUncalibrated(stage, ReadRigCalibration(stage.Input("calibration")), shot.cameras);
  const std::vector<ShotCamera> with = Cameras(shot, true), without = Cameras(shot, false);
  const std::filesystem::path out = stage.Output("masked") / "masks";
  const double share = static_cast<double>(with.size()) / SizeOf(shot.cameras);
  SubProgress first(stage.progress(), 0, share);
  int empty = WriteByPlates(stage, with, options, out, &first);
  if (!without.empty()) {
    const std::filesystem::path calibration =
        stage.Has("calibration") ? stage.Input("calibration") : std::filesystem::path();
    const FilmSilhouettesRequest request{options.mask_px, options.figure, options.network};
    empty += WriteFilmSilhouettes(stage, without, calibration, request, out).empty;
  }
  int frames = 0;
  for (const ShotCamera& camera : shot.cameras) frames += camera.frames();
  if (shot.frames_per_second > 0) WriteShotRate(stage.Output("masked"), shot.frames_per_second);
  stage.Report("masks", frames);
  stage.Report("empty_masks", empty);
  if (empty > 0)
    stage.Warn(std::to_string(empty) + " of " + std::to_string(frames) +
               " masks are empty: in them the actor looks like the set, or is not there");
}

}  // namespace
}  // namespace keypose::capture

int main(int argc, char** argv) {
  return keypose::RunStage<keypose::capture::SilhouettesOptions>(
      argc, argv, keypose::capture::Spec(), keypose::capture::Run);
}
