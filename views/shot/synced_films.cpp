#include "views/shot/synced_films.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/pictures/image_io.h"
#include "core/io/project/rig_calibration.h"
#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "core/values/name_list.h"
#include "core/values/size_of.h"
#include "views/shot/shot_views.h"
#include "views/shot/view_for_pictures.h"

namespace keypose {
namespace {

/// Takes the shot's cameras of these names, all where none are given.
std::vector<ShotCamera> Chosen(const Shot& shot, const FilmsRequest& request) {
  const std::vector<std::string> wanted = NamesIn(request.cameras), known = shot.names();
  for (const std::string& name : wanted)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(request.stage + ": --cameras names " + name + ", but the shot has " +
                       Listed(known));
  std::vector<ShotCamera> chosen;
  for (const ShotCamera& camera : shot.cameras)
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), camera.name) != wanted.end())
      chosen.push_back(camera);
  return chosen;
}

void TakeMasksOf(const Shot& shot, ShotCamera& camera) {
  for (const ShotCamera& other : shot.cameras)
    if (other.name == camera.name && !other.masks.empty()) TakeMasks(other.masks, &camera);
}

}  // namespace

std::vector<Port> MovingMeshPorts() {
  return {{"frames", "folder", "frames of the moving mesh, in the calibration's space", "", false,
           false},
          {"video", "folder", "one folder of numbered pictures, or one video, for each camera", "",
           false, false},
          {"calibration", "path",
           "cameras: OpenCV YAML, a COLMAP model, Qualisys' text, or matrices", "", false, false},
          {"masks", "folder", "masks/CAMERA/ of the films; by default those beside the films", "",
           true, false},
          {"clocks", "file", "clocks.json of track: offsets between the films", "", true, false},
          {"layout", "file", "the mesh with texture coordinates, where the frames have none", "",
           true, false}};
}

SyncedFilms::~SyncedFilms() = default;
SyncedFilms::SyncedFilms(SyncedFilms&&) noexcept = default;

SyncedFilms::SyncedFilms(StageContext& stage, const FilmsRequest& request) : request_(request) {
  Open(stage);
  ReadClocks(stage);
  CheckLengths(stage);
  CheckSizes(stage);
}

void SyncedFilms::Open(StageContext& stage) {
  Shot shot = OpenShot(stage.Input("video"), FilmGaps::kRefused, ReadFilmClocks(stage));
  for (const std::string& note : shot.join.notes) stage.Note(note);
  const RigCalibration rig = ReadRigCalibration(stage.Input("calibration"));
  for (const std::string& note : rig.notes) stage.Note(note);
  LeaveOutUncalibrated(stage, rig, shot.cameras);
  rate_ = shot.frames_per_second;
  std::vector<std::string> names, bare;
  for (const ShotCamera& camera : Chosen(shot, request_)) {
    if (camera.pictures.empty())
      throw InputError(request_.stage + ": camera " + camera.name +
                       " has masks but no film; pass the folder with the films as --video and the "
                       "masks as --masks");
    films_.emplace_back();
    films_.back().files = camera;
    names.push_back(camera.name);
  }
  if (stage.Has("masks")) {
    const Shot masks = OpenShot(stage.Input("masks"));
    for (CameraFilm& film : films_) TakeMasksOf(masks, film.files);
  }
  for (const CameraFilm& film : films_)
    if (film.files.masks.empty()) bare.push_back(film.files.name);
  if (request_.need_masks && !bare.empty())
    throw InputError(request_.stage + ": there are no masks of camera " + Listed(bare) +
                     "; `keypose silhouettes` makes them from films and pictures of the empty "
                     "set: pass its result as --masks");
  views_ = MatchedViews(rig, names, request_.stage);
  up_ = rig.up;
  for (CameraFilm& film : films_) {
    film.pictures = std::make_unique<FrameReader>(film.files.pictures);
    if (!film.files.masks.empty())
      film.masks = std::make_unique<GivenMasks>(film.files, request_.stage);
  }
}

nlohmann::json SyncedFilms::ClocksJson(StageContext& stage) const {
  nlohmann::json root = nlohmann::json::parse(ReadFile(stage.Input("clocks")), nullptr, false);
  if (!root.is_object() || !root.contains("offsets") || !root["offsets"].is_object())
    throw InputError(ClocksName(stage) + " is not JSON with an object `offsets`");
  return root;
}

std::string SyncedFilms::ClocksName(StageContext& stage) const {
  return request_.stage + ": " + stage.Input("clocks").filename().string();
}

ClockWish SyncedFilms::ReadFilmClocks(StageContext& stage) const {
  ClockWish wish;
  if (!stage.Has("clocks")) return wish;
  const nlohmann::json root = ClocksJson(stage);
  if (!root.contains("films")) return wish;
  const auto number = [](const nlohmann::json& of, const char* key) {
    return of.is_object() && of.contains(key) && of[key].is_number();
  };
  for (const auto& [camera, clock] : root["films"].items()) {
    if (!number(clock, "begin_s") || !number(clock, "rate") || !(clock["rate"] > 0))
      throw InputError(ClocksName(stage) + ": the film of " + camera +
                       " has no number `begin_s`, or no `rate` above 0");
    wish.named[camera] = {clock["begin_s"], clock["rate"]};
  }
  if (!wish.named.empty()) wish.how = ClockWish::How::kGiven;
  return wish;
}

void SyncedFilms::ReadClocks(StageContext& stage) {
  if (!stage.Has("clocks")) return;
  const std::string name = ClocksName(stage);
  const nlohmann::json root = ClocksJson(stage);
  for (CameraFilm& film : films_) {
    if (!root["offsets"].contains(film.files.name)) continue;
    const nlohmann::json& offset = root["offsets"][film.files.name];
    if (!offset.is_number_integer())
      throw InputError(name + ": the offset of " + film.files.name +
                       " is not a whole number of frames");
    film.offset = offset;
  }
}

void SyncedFilms::CheckLengths(StageContext& stage) {
  const int frames = request_.frames;
  std::vector<std::string> some;
  int longest = 0;
  for (const CameraFilm& film : films_) {
    const int count = std::clamp(film.files.frames() - film.offset, 0, frames);
    longest = std::max(longest, count);
    if (count < frames)
      some.push_back(film.files.name + " (" + std::to_string(count) + " of " +
                     std::to_string(frames) + ")");
  }
  if (longest == 0)
    throw InputError(request_.stage +
                     ": no film has a frame of this motion; the offsets of the clocks are "
                     "beyond the films' ends");
  if (some.empty()) return;
  stage.Warn("films end before the motion does: " + Listed(some) + "; later frames are " +
             request_.done + " from the other cameras" +
             (longest < frames ? ", and those after all films' ends from the frames before" : "") +
             "; copy the films again");
}

void SyncedFilms::CheckSizes(StageContext& stage) {
  for (std::size_t v = 0; v < views_.size(); ++v) {
    const int first = std::clamp(films_[v].offset, 0, films_[v].files.frames() - 1);
    const Image8 picture = films_[v].pictures->Read(first, 3);
    const AdjustedView filmed = ViewForPictures(views_[v], picture, up_, request_.stage);
    if (!filmed.note.empty()) stage.Note(filmed.note);
    views_[v] = filmed.view;
    if (!films_[v].masks) continue;
    const FrameSource& files = films_[v].files.pictures;
    const int orientation =
        files.pictures.empty() ? 1 : ReadImageInfo(files.pictures.front()).orientation;
    films_[v].masks->FitTo(picture.width, picture.height, orientation);
    for (const std::string& warning : films_[v].masks->warnings()) stage.Warn(warning);
  }
}

FilmedPictures SyncedFilms::Read(int frame, bool pictures) {
  FilmedPictures read;
  read.pictures.resize(films_.size());
  read.masks.resize(films_.size());
  ParallelFor(SizeOf(films_), [&](std::int64_t v) {
    CameraFilm& film = films_[v];
    const int at = frame + film.offset;
    if (at < 0 || at >= film.files.pictures.frames) return;
    if (pictures) read.pictures[v] = film.pictures->Read(at, 3);
    if (film.masks && at < film.files.masks.frames) read.masks[v] = film.masks->Read(at);
  });
  return read;
}

}  // namespace keypose
