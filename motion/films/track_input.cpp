#include "motion/films/track_input.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/name_list.h"
#include "core/values/size_of.h"
#include "motion/tracking/camera_turns.h"
#include "views/shot/shot_views.h"
#include "views/shot/view_for_pictures.h"

namespace keypose::motion {
namespace {

using Eigen::Vector3d;

constexpr double kMaskSide = 500;               // [px] longer side of the reduced masks
constexpr int kOutlinePoints = 220;             // of a view, that pull at the template
constexpr int kClockFrames = 90;                // that clocks are compared over
constexpr std::int64_t kMostKnown = 128 << 20;  // [bytes] of masks that are kept
constexpr double kUpright = 0.87;               // cosine of 30 degrees
constexpr double kUsualHeight = 1.72;           // [m] where nothing tells the unit

std::string Rounded(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", x);
  return text;
}

void ScalePlaces(double factor, std::vector<View>* views) {
  for (View& view : *views) view.camera_from_world.translation *= factor;
}

/// Which unit makes the height one of a person: metres, centimetres, millimetres; 0: none.
double UnitOfHeight(double height) {
  for (const double unit : {1.0, 0.01, 0.001})
    if (height * unit > 1.0 && height * unit < 2.6) return unit;
  return 0;
}

/// The shot, with masks from another folder where the stage has them.
Shot ShotWithMasks(StageContext& stage, const std::filesystem::path& folder,
                   const ClockWish& clocks) {
  Shot shot = OpenShot(folder, FilmGaps::kRefused, clocks, stage.progress());
  for (const std::string& note : shot.join.notes) stage.Note(note);
  if (shot.join.frames_per_second > 0) stage.Report("film_mismatch_ms", 1000 * shot.join.worst_s);
  if (!stage.Has("masks")) return shot;
  const Shot masks = OpenShot(stage.Input("masks"));
  for (ShotCamera& camera : shot.cameras)
    for (const ShotCamera& other : masks.cameras) {
      if (other.name != camera.name || other.masks.empty()) continue;
      TakeMasks(other.masks, &camera);
      if (!camera.pictures.empty() && camera.masks.frames != camera.pictures.frames)
        throw InputError("track: camera " + camera.name + " has " +
                         std::to_string(camera.pictures.frames) + " frames but " +
                         std::to_string(camera.masks.frames) +
                         " masks in --masks; a mask for each frame is needed");
    }
  if (!(shot.frames_per_second > 0)) shot.frames_per_second = masks.frames_per_second;
  return shot;
}

}  // namespace

TrackInput::~TrackInput() = default;

TrackInput::TrackInput(StageContext& stage, const std::filesystem::path& shot_folder,
                       const TrackInputOptions& options)
    : shot_(ShotWithMasks(stage, shot_folder, options.clocks)) {
  Match(stage, options);
  if (!shot_.has_masks())
    throw InputError(
        "track: the shot " + shot_folder.filename().string() +
        " has no masks/CAMERA/ for each camera; `keypose silhouettes` makes them from films and "
        "pictures of the empty set");
  CountFrames(stage);
  OpenMasks(stage);
  for (const ShotCamera& camera : shot_.cameras)
    pictures_.push_back(
        std::make_unique<FrameReader>(camera.pictures.empty() ? camera.masks : camera.pictures));
  offsets_.assign(shot_.cameras.size(), 0);
  for (int c = 0; c < SizeOf(views_); ++c) {
    const AdjustedView filmed = ViewForPictures(views_[c], Shown(c), calibrated_up_, "track");
    if (!filmed.note.empty()) stage.Note(filmed.note);
    views_[c] = filmed.view;
  }
  const Vector3d up = UpOf(options.up, views_);
  if (up.z() < kUpright)
    stage.Warn(
        "up in the pictures is not z of the calibration, and the tracked frames lie in its axes; "
        "`transfer` and `export` take z for up: turn the calibration so that z is up, or, if its y "
        "is up, give `export` up: y");
  up_from_world_ = Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ());
  MakeCameras();
  FindUnit(stage, options);
  FindClocks(stage, options);
  Compare(stage, std::min(options.at_frame, frames_ - 1));
}

void TrackInput::OpenMasks(StageContext& stage) {
  constexpr int kOnItsSide = 5;  // and above, as EXIF counts
  for (const ShotCamera& camera : shot_.cameras) {
    masks_.push_back(std::make_unique<GivenMasks>(camera, "track"));
    if (!camera.pictures.pictures.empty()) {
      const ImageInfo info = ReadImageInfo(camera.pictures.pictures.front());
      if (info.orientation >= kOnItsSide)
        masks_.back()->FitTo(info.width, info.height, info.orientation);
    }
    for (const std::string& warning : masks_.back()->warnings()) stage.Warn(warning);
  }
}

void TrackInput::Match(StageContext& stage, const TrackInputOptions& options) {
  const RigCalibration rig = ReadRigCalibration(stage.Input("calibration"));
  for (const std::string& note : rig.notes) stage.Note(note);
  LeaveOutUncalibrated(stage, rig, shot_.cameras);
  const std::vector<std::string> names = shot_.names();
  views_ = MatchedViews(rig, names, "track");
  metres_per_unit_ = rig.metres_per_unit;
  calibrated_up_ = rig.up;
  std::vector<std::string> wanted = NamesIn(options.cameras);
  for (const std::string& name : wanted)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw UsageError("track: --cameras names " + name + ", but the shot has " + Listed(names));
  for (int c = 0; c < SizeOf(names); ++c) {
    const bool use =
        wanted.empty() || std::find(wanted.begin(), wanted.end(), names[c]) != wanted.end();
    (use ? used_ : compared_).push_back(c);
  }
  if (used_.size() < 2)
    throw InputError(
        "track: one camera does not tell depth; at least two are needed, eight are good");
}

Image8 TrackInput::Shown(int camera) {
  Image8 mask = Mask(camera, 0);
  if (shot_.cameras[camera].pictures.empty()) return mask;
  const Image8 picture = Picture(camera, 0);
  return picture.width == mask.width && picture.height == mask.height ? picture : mask;
}

void TrackInput::CountFrames(StageContext& stage) {
  std::vector<int> counts;
  for (const ShotCamera& camera : shot_.cameras) counts.push_back(camera.frames());
  frames_ = *std::min_element(counts.begin(), counts.end());
  const int most = *std::max_element(counts.begin(), counts.end());
  if (frames_ == most) return;
  const auto shortest = std::min_element(counts.begin(), counts.end()) - counts.begin();
  const std::string fact = "camera " + shot_.cameras[shortest].name + " has only " +
                           std::to_string(frames_) + " frames, where others have " +
                           std::to_string(most);
  if (2 * frames_ < most)
    throw InputError("track: " + fact + "; copy its film again, or leave it out with --cameras");
  stage.Warn(fact + ": only the first " + std::to_string(frames_) + " frames are tracked");
}

void TrackInput::MakeCameras() {
  cameras_.clear();
  known_.clear();
  known_.resize(views_.size());
  for (const View& view : views_) {
    const double side = std::max(view.camera.width, view.camera.height);
    cameras_.emplace_back(view, std::min(1.0, kMaskSide / side));
  }
}

void TrackInput::TurnCameras(const std::vector<Vector3d>& turns) {
  for (std::size_t i = 0; i < used_.size(); ++i) {
    View& view = views_[used_[i]];
    view.camera_from_world = TurnedBy(view.camera_from_world, turns[i]);
    const double side = std::max(view.camera.width, view.camera.height);
    cameras_[used_[i]] = SilhouetteCamera(view, std::min(1.0, kMaskSide / side));
  }
}

void TrackInput::FindUnit(StageContext& stage, const TrackInputOptions& options) {
  if (metres_per_unit_ > 0) {
    ScalePlaces(metres_per_unit_, &views_);
    MakeCameras();
  }
  Compare(stage, std::min(options.at_frame, frames_ - 1));
  const double height = hull_.high.z() - hull_.low.z();
  if (metres_per_unit_ > 0) {
    if (UnitOfHeight(height) != 1)
      stage.Warn("the actor is " + Rounded(height) +
                 " m high by this calibration: its unit may be wrong");
    return;
  }
  double unit = UnitOfHeight(height);
  if (options.height_m > 0) unit = options.height_m / height;
  const bool guessed = unit == 0;
  if (guessed) unit = kUsualHeight / height;
  metres_per_unit_ = unit;
  if (unit == 1) return;
  stage.Note("the calibration does not say its unit; the actor is " + Rounded(height) +
             " units high, so a unit is taken as " + Rounded(unit) + " m");
  if (guessed)
    stage.Warn("the calibration's unit is not known: lengths assume that the actor is " +
               Rounded(kUsualHeight) + " m tall; give height_m");
  ScalePlaces(unit, &views_);
  MakeCameras();
}

void TrackInput::Compare(StageContext& stage, int frame) {
  const std::vector<Silhouette> silhouettes = Read(frame, 1)[0];
  std::vector<std::string> empty;
  for (std::size_t i = 0; i < silhouettes.size(); ++i)
    if (silhouettes[i].empty()) empty.push_back(views_[used_[i]].name);
  if (silhouettes.size() - empty.size() < 2)
    throw InputError("track: in frame " + std::to_string(frame) + " the masks of " + Listed(empty) +
                     " are empty; begin where all cameras see the actor, or look at the masks");
  const RigAgreement agreement = CheckAgreement(silhouettes, up_from_world_);
  if (agreement.hull.voxels == 0)
    throw InputError(
        "track: the cameras do not see one place: no point of space lies in the masks of "
        "all of them in frame " +
        std::to_string(frame) + "; they do not overlap, or the calibration is of another shot");
  if (!agreement.against.empty()) {
    const int place = agreement.against.front();
    const View& view = views_[used_[place]];
    std::string text = "track: camera " + view.name +
                       " does not agree with the others: what it shows is " +
                       "not where they see the actor. ";
    if (AgreesScaled(silhouettes, place, 0.001, up_from_world_))
      text += "Its place looks like millimetres among metres: divide its translation by 1000";
    else if (AgreesScaled(silhouettes, place, 1000, up_from_world_))
      text += "Its place looks like metres among millimetres: multiply its translation by 1000";
    else
      text += "Calibrate it again, check its name, or leave it out with --cameras";
    throw InputError(text);
  }
  hull_ = agreement.hull;
  (void)stage;
}

void TrackInput::FindClocks(StageContext& stage, const TrackInputOptions& options) {
  const int most = std::min(options.sync_frames, frames_ / 4);
  if (most < 1) return;
  const int count = std::min(frames_, kClockFrames);
  std::vector<std::vector<OutlineRays>> rays(used_.size());
  for (const std::vector<Silhouette>& frame : Read(0, count))
    for (std::size_t c = 0; c < frame.size(); ++c) rays[c].push_back(RaysOf(frame[c]));
  std::vector<Vector3d> centers;
  for (const int c : used_) centers.push_back(views_[c].Center());
  const ClockOffsets clocks =
      FindClockOffsets(rays, centers, up_from_world_.conjugate() * hull_.middle, most);
  const int latest = *std::max_element(clocks.frames.begin(), clocks.frames.end());
  stage.Report("clock_disagreement_mrad", 1000 * clocks.after);
  if (latest == 0) return;
  std::string text;
  for (std::size_t c = 0; c < used_.size(); ++c) {
    offsets_[used_[c]] = clocks.frames[c];
    if (clocks.frames[c] != 0)
      text += (text.empty() ? "" : ", ") + views_[used_[c]].name + " by " +
              std::to_string(clocks.frames[c]);
  }
  frames_ -= latest;
  stage.Warn("the cameras' clocks differ: frames are taken later from " + text +
             " (disagreement of the outlines " + Rounded(1000 * clocks.before) + " before, " +
             Rounded(1000 * clocks.after) + " mrad after); check a fast movement");
}

std::vector<std::vector<Silhouette>> TrackInput::Read(int first, int count, int step) {
  std::vector<std::vector<Silhouette>> frames(static_cast<std::size_t>(count),
                                              std::vector<Silhouette>(used_.size()));
  // A camera's frames are read in order by one thread.
  ParallelFor(SizeOf(used_), [&](std::int64_t i) {
    const int camera = used_[i];
    for (int f = 0; f < count; ++f) {
      const Image8 reduced = ReducedMask(camera, first + f * step + offsets_[camera]);
      frames[f][i] = MakeSilhouette(cameras_[camera], camera, reduced, kOutlinePoints);
    }
  });
  return frames;
}

/// @param frame  of the camera's own film
Image8 TrackInput::ReducedMask(int camera, int frame) {
  KnownMasks& known = known_[camera];
  const auto found = known.frames.find(frame);
  if (found != known.frames.end()) return found->second.Mask();
  Image8 reduced = cameras_[camera].Reduced(masks_[camera]->Read(frame));
  if (known.bytes < kMostKnown / SizeOf(used_))
    known.bytes += known.frames.try_emplace(frame, reduced).first->second.bytes();
  return reduced;
}

Image8 TrackInput::Mask(int camera, int frame) {
  return masks_[camera]->Read(frame + offsets_[camera]);
}

Image8 TrackInput::Picture(int camera, int frame) {
  return pictures_[camera]->Read(frame + offsets_[camera], 3);
}

}  // namespace keypose::motion
