#include "studio/project/camera_points.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/io/project/known_points_io.h"
#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/graph/pipeline_edit.h"
#include "pipeline/graph/sources.h"
#include "studio/project/changes.h"
#include "studio/project/films.h"
#include "studio/project/not_found.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::PipelineFile;
using pipeline::PoseRule;

namespace {

/// A folder of lenses lies at most so deep in the project.
constexpr int kOfferDepth = 3;
constexpr std::size_t kMostOffers = 200;
constexpr double kLeastSquare_mm = 2, kMostSquare_mm = 500;

PipelineFile PerformanceOf(const fs::path& project) {
  const fs::path path = project / "pipeline.yaml";
  if (!fs::is_regular_file(path)) throw UsageError("there is no project in this folder yet");
  PipelineFile file = pipeline::ParsePipelineFile(ReadFile(path), "pipeline.yaml");
  if (file.kind != pipeline::ProjectKind::kPerformance)
    throw UsageError("only a performance has cameras to calibrate by points");
  return file;
}

fs::path NotesFolder(const fs::path& project) { return project / ".keypose/studio/calibration"; }

/// What points.json holds; nothing where it is not there. @throws InputError
KnownPoints PointsIn(const fs::path& project) {
  const fs::path file = project / kPointsFile;
  return fs::is_regular_file(file) ? ReadKnownPoints(file) : KnownPoints{};
}

/// What is shown of a camera, and in words.
struct Still {
  std::string camera, words, picture;
  FrameSource film;
};

FrameSource OnePicture(const fs::path& picture) {
  FrameSource film;
  film.pictures = {picture};
  film.frames = 1;
  return film;
}

/// The picture that points.json names, where it lies in the project.
void AddNamedPicture(const fs::path& project, const ClickedPicture& camera, Still* still) {
  if (camera.picture.empty()) return;
  const fs::path picture = project / camera.picture;
  if (!fs::is_regular_file(picture) || pipeline::RealDisk().LeadsOutside(picture, project)) return;
  still->film = OnePicture(picture);
  still->words = still->picture = camera.picture;
}

/// The empty set where there is a picture of it, which shows every point; else the film.
Still StillOfFilm(const fs::path& folder, const std::string& shot, const ShotCamera& camera) {
  const fs::path sets = folder / "background";
  if (fs::is_directory(sets))
    for (const fs::path& picture : NumberedContent(sets))
      if (picture.stem() == camera.name && IsFramePicture(picture) &&
          !pipeline::RealDisk().LeadsOutside(picture, folder))
        return {camera.name, fmt::format("the empty set of {}", shot), "", OnePicture(picture)};
  return {camera.name, fmt::format("the film of {}", shot), "", camera.pictures};
}

/// All cameras: those of points.json first, then others that have films.
/// @param problem  why films cannot be shown
std::vector<Still> StillsOf(const fs::path& project, const PipelineFile& file,
                            const KnownPoints& known, std::string* problem = nullptr) {
  std::vector<Still> stills;
  const auto find = [&](const std::string& name) {
    return std::find_if(stills.begin(), stills.end(),
                        [&](const Still& still) { return still.camera == name; });
  };
  for (const ClickedPicture& camera : known.cameras) {
    stills.push_back({camera.camera, "", "", {}});
    AddNamedPicture(project, camera, &stills.back());
  }
  for (const PoseRule& shot : file.poses) try {
      const fs::path folder = FilmFolder(project, file, shot.name);
      for (const ShotCamera& camera : FilmsIn(folder)) {
        const auto there = find(camera.name);
        if (there == stills.end())
          stills.push_back(StillOfFilm(folder, shot.name, camera));
        else if (there->film.empty())
          *there = StillOfFilm(folder, shot.name, camera);
      }
    } catch (const Error& error) {
      if (problem) *problem = error.what();
    }
  return stills;
}

json CameraJson(const Still& still, const KnownPoints& known) {
  const PictureSize size = still.film.empty() ? PictureSize{} : FrameSize(still.film, 0);
  json camera = {{"name", still.camera},  {"width", size.width},
                 {"height", size.height}, {"frames", still.film.frames > 1 ? still.film.frames : 0},
                 {"still", still.words},  {"problem", ""}};
  if (still.film.empty()) camera["problem"] = "there is no picture of this camera";
  for (const ClickedPicture& clicked : known.cameras)
    if (clicked.camera == still.camera && !still.film.empty() && !clicked.clicks.empty() &&
        (clicked.width != size.width || clicked.height != size.height))
      camera["problem"] = fmt::format(
          "its clicks are of a picture of {} x {} pixels; the one that is shown has {} x {}",
          clicked.width, clicked.height, size.width, size.height);
  return camera;
}

/// What the lenses may come from: folders with pictures of a board for each camera, calibrations.
void AddOffers(const fs::path& project, const fs::path& below, int depth, json* offers) {
  const pipeline::RealDisk disk;
  std::vector<std::string> names = disk.Children(project / below);
  std::sort(names.begin(), names.end());
  for (const std::string& name : names) {
    const fs::path path = below / name;
    if (name.starts_with('.') || offers->size() >= kMostOffers || !IsValidUtf8(name)) continue;
    if (below.empty() && (name == "out" || name == "pipeline.yaml")) continue;
    if (disk.LeadsOutside(project / path, project)) continue;
    if (fs::is_directory(project / path)) {
      const auto films = CameraFilms(project / path);
      if (!films.empty() && std::all_of(films.begin(), films.end(),
                                        [](const CameraFilm& film) { return film.video.empty(); }))
        offers->push_back(path.generic_string());
      else if (depth + 1 < kOfferDepth)
        AddOffers(project, path, depth + 1, offers);
    } else if (const std::string end = LowerExtension(path); end == ".yml" || end == ".yaml") {
      offers->push_back(path.generic_string());
    }
  }
}

json OffersJson(const fs::path& project) {
  json offers = json::array();
  try {
    AddOffers(project, "", 0, &offers);
  } catch (const Error&) {
    // A folder that cannot be read offers nothing.
  }
  return offers;
}

/// The file that a shot's steps take; "" for none.
std::string CalibrationOf(const fs::path& project, const PipelineFile& file, const PoseRule& shot) {
  if (const auto* given = shot.Given("calibration")) return given->text;
  for (const fs::path& folder : {FilmFolder(project, file, shot.name), project}) {
    if (!fs::is_directory(folder)) continue;
    for (const std::string& name : pipeline::RealDisk().Children(folder))
      if (fs::path(name).stem() == "calibration")
        return folder == project ? name : (folder / name).string();
  }
  return "";
}

json ShotsJson(const fs::path& project, const PipelineFile& file) {
  json shots = json::array();
  for (const PoseRule& shot : file.poses) {
    const std::string taken = CalibrationOf(project, file, shot);
    shots.push_back(
        {{"name", shot.name}, {"calibration", taken}, {"ours", taken == kCalibrationFile}});
  }
  return shots;
}

/// What the last calibration told of each camera, click and point; null: there was none.
json CalibrationResultJson(const fs::path& project) {
  const fs::path report = NotesFolder(project) / "report.json",
                 note = NotesFolder(project) / "made.json";
  if (!fs::is_regular_file(report) || !fs::is_regular_file(note)) return nullptr;
  try {
    const json told = JsonOfFile(report), made = JsonOfFile(note);
    const json measured = told.value("measurements", json::object());
    const fs::path file = project / kCalibrationFile;
    return {{"cameras", measured.value("cameras", json::array())},
            {"points", measured.value("points", json::array())},
            {"warnings", told.value("warnings", json::array())},
            {"lenses", made.value("lenses", "")},
            {"square_mm", made.value("square_mm", 0.0)},
            {"stale", made.value("revision", "") != RevisionOf(project / kPointsFile)},
            {"gone", RevisionOf(file) != made.value("calibration", "")}};
  } catch (const std::exception&) {
    return nullptr;  // notes of the studio's own, which the next calibration writes anew
  }
}

/// What the page has sent, as points.json has it; of cameras, those that it shall have.
json WrittenPoints(const json& body, const KnownPoints& known, const std::vector<Still>& stills) {
  json root = {{"schema", 1}, {"unit", "m"}, {"cameras", json::array()}};
  for (const char* list : {"points", "clicks"}) root[list] = body.at(list);
  for (const json& point : root["points"])
    if (point.is_object() && point.value("name", json()) == "")
      throw UsageError("a point has no name");
  for (const Still& still : stills) {
    const auto there = std::find_if(known.cameras.begin(), known.cameras.end(),
                                    [&](const auto& one) { return one.camera == still.camera; });
    const bool clicked =
        std::any_of(body.at("clicks").begin(), body.at("clicks").end(), [&](const json& click) {
          return click.is_object() && click.value("camera", json()) == still.camera;
        });
    if (there == known.cameras.end() && !clicked) continue;
    // Clicks of another picture stay clicks of that one until they are taken out.
    const bool of_before = there != known.cameras.end() && !there->clicks.empty() && clicked;
    const PictureSize size = still.film.empty() || of_before
                                 ? PictureSize{there->width, there->height}
                                 : FrameSize(still.film, 0);
    json camera = {{"name", still.camera}, {"size", {size.width, size.height}}};
    if (there != known.cameras.end() && !there->picture.empty()) camera["picture"] = there->picture;
    root["cameras"].push_back(camera);
  }
  return root;
}

}  // namespace

json CameraPointsJson(const fs::path& project) {
  const PipelineFile file = PerformanceOf(project);
  json page = {{"revision", RevisionOf(project / kPointsFile)},
               {"problem", ""},
               {"points", json::array()},
               {"clicks", json::array()},
               {"cameras", json::array()}};
  KnownPoints known;
  std::string problem;
  try {
    known = PointsIn(project);
  } catch (const Error& error) {
    problem = error.what();
  }
  for (const KnownPoint& point : known.points)
    page["points"].push_back(
        {{"name", point.name}, {"place", {point.place.x(), point.place.y(), point.place.z()}}});
  for (const ClickedPicture& camera : known.cameras)
    for (const PointClick& click : camera.clicks)
      page["clicks"].push_back({{"camera", camera.camera},
                                {"point", known.points[click.point].name},
                                {"pixel", {click.pixel.x(), click.pixel.y()}}});
  for (const Still& still : StillsOf(project, file, known, problem.empty() ? &problem : nullptr))
    page["cameras"].push_back(CameraJson(still, known));
  page["problem"] = problem;
  page["offers"] = OffersJson(project);
  page["shots"] = ShotsJson(project, file);
  page["result"] = CalibrationResultJson(project);
  return page;
}

void SaveCameraPoints(const fs::path& project, const json& body) {
  const PipelineFile file = PerformanceOf(project);
  const fs::path path = project / kPointsFile;
  if (pipeline::RealDisk().LeadsOutside(path, project))
    throw UsageError("points.json is a link that leads out of the project");
  if (RevisionOf(path) != body.at("revision"))
    throw ChangedMeanwhile("points.json was changed elsewhere; it was read again");
  KnownPoints known;
  try {
    known = PointsIn(project);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}; mend or delete it in an editor first", error.what()));
  }
  const fs::path draft = NotesFolder(project) / kPointsFile;
  fs::create_directories(draft.parent_path());
  WriteFileAtomically(draft, WrittenPoints(body, known, StillsOf(project, file, known)).dump());
  WriteFileAtomically(path, KnownPointsText(ReadKnownPoints(draft)));
}

FrameSource StillOf(const fs::path& project, const std::string& camera) {
  KnownPoints known;
  try {
    known = PointsIn(project);
  } catch (const Error&) {
    // Its films can be shown all the same.
  }
  for (Still& still : StillsOf(project, PerformanceOf(project), known))
    if (still.camera == camera && !still.film.empty()) return std::move(still.film);
  throw NotFound(fmt::format("there is no picture of a camera '{}'", camera));
}

std::vector<std::string> CalibrateFlags(const fs::path& project, const std::string& lenses,
                                        double square_mm) {
  PerformanceOf(project);
  if (!fs::is_regular_file(project / kPointsFile)) throw UsageError("no point is clicked yet");
  std::vector<std::string> flags = {"--points",      (project / kPointsFile).string(),
                                    "--calibration", (NotesFolder(project) / "made.yml").string(),
                                    "--report",      (NotesFolder(project) / "new.json").string()};
  fs::create_directories(NotesFolder(project));
  json note = {{"lenses", lenses}, {"square_mm", square_mm}};
  if (!lenses.empty()) {
    const json offers = OffersJson(project);
    if (std::find(offers.begin(), offers.end(), lenses) == offers.end())
      throw UsageError(fmt::format(
          "'{}' is no folder of pictures of a board for each camera, and no calibration, in this "
          "project",
          lenses));
    if (!(square_mm >= kLeastSquare_mm && square_mm <= kMostSquare_mm))
      throw UsageError("a board's squares are 2 to 500 mm wide");
    flags.insert(flags.end(), {"--lenses", (project / lenses).string(), "--board_square_mm",
                               fmt::format("{}", square_mm)});
  }
  WriteFileAtomically(NotesFolder(project) / "asked.json", note.dump());
  return flags;
}

void TakeCalibration(const fs::path& project, const std::string& revision) {
  const fs::path notes = NotesFolder(project), file = project / kCalibrationFile;
  json made = JsonOfFile(notes / "asked.json");
  const json before = CalibrationResultJson(project);
  // One's own of before is in points.json; what came from elsewhere would be lost.
  const bool ours = before.is_object() && before.at("gone") == false;
  if (fs::exists(file) && !ours) fs::rename(file, project / "calibration.before.yml");
  fs::rename(notes / "new.json", notes / "report.json");
  fs::copy_file(notes / "made.yml", file, fs::copy_options::overwrite_existing);
  made["revision"] = revision;
  made["calibration"] = RevisionOf(file);
  WriteFileAtomically(notes / "made.json", made.dump());
}

void UseCalibration(const fs::path& project, const std::string& shot) {
  const fs::path path = project / "pipeline.yaml";
  const std::string revision = RevisionOf(path), text = ReadFile(path);
  const PipelineFile file = PerformanceOf(project);
  FilmFolder(project, file, shot);
  if (!fs::is_regular_file(project / kCalibrationFile))
    throw UsageError("there is no calibration.yml yet");
  WritePipelineFile(project, Edited([&] {
                      return pipeline::WithPoseSetting(file, text, shot, {"calibration"},
                                                       kCalibrationFile);
                    }),
                    revision);
}

}  // namespace keypose::studio
