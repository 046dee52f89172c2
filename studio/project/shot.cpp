#include "studio/project/shot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/errors.h"
#include "core/file_names.h"
#include "core/io/files.h"
#include "core/io/image_io.h"
#include "core/io/shot_io.h"
#include "core/io/yaml_edit.h"
#include "pipeline/project_paths.h"
#include "pipeline/real_disk.h"
#include "studio/project/changes.h"
#include "studio/project/photographs.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::ShotRule;

namespace {

constexpr int kDeepestFilm = 3, kMostFolders = 400;
constexpr std::size_t kMostClicks = 1000;

fs::path Resolved(Snapshot& snapshot, const std::string& text) {
  return snapshot.project() /
         pipeline::OnDisk(pipeline::RealDisk(), snapshot.project(), pipeline::WithHome(text));
}

bool IsInProject(Snapshot& snapshot, const fs::path& path) {
  return IsWithin(fs::weakly_canonical(path), fs::canonical(snapshot.project()));
}

const ShotRule& ShotOf(Snapshot& snapshot) {
  if (!snapshot.file().shot) throw UsageError("the project has no filmed shot yet");
  return *snapshot.file().shot;
}

/// Without those that are links to other places.
std::vector<FilmPicture> PicturesOf(const fs::path& film) {
  std::vector<FilmPicture> pictures = FilmPictures(film);
  std::erase_if(pictures, [&](const FilmPicture& picture) {
    return pipeline::RealDisk().LeadsOutside(picture.path, film);
  });
  return pictures;
}

int PictureCount(const fs::path& folder) {
  try {
    return static_cast<int>(PicturesOf(folder).size());
  } catch (const Error&) {
    return 0;
  }
}

/// Folders of the project with numbered pictures, those of its own making left out.
json FilmFolders(Snapshot& snapshot) {
  static const std::set<std::string> kOthers = {"out",       "photos",  "masks",
                                                "landmarks", "results", "node_modules"};
  json folders = json::array();
  std::error_code ignored;
  int visited = 0;
  for (auto it = fs::recursive_directory_iterator(
           snapshot.project(), fs::directory_options::skip_permission_denied, ignored);
       it != fs::recursive_directory_iterator() && visited < kMostFolders; it.increment(ignored)) {
    if (!it->is_directory(ignored) || it->is_symlink(ignored)) continue;
    const std::string name = it->path().filename().string();
    const bool other = it.depth() == 0 && kOthers.contains(name);
    if (other || name.starts_with(".") || it.depth() >= kDeepestFilm || !IsValidUtf8(name)) {
      it.disable_recursion_pending();
      continue;
    }
    ++visited;
    if (const int count = PictureCount(it->path()); count > 1)
      folders.push_back(
          {{"path", it->path().lexically_relative(snapshot.project()).generic_string()},
           {"pictures", count}});
  }
  std::sort(folders.begin(), folders.end(),
            [](const json& a, const json& b) { return a["path"] < b["path"]; });
  return folders;
}

std::string TextOf(const std::optional<pipeline::Setting>& setting) {
  return setting ? setting->text : "";
}

json FilmJson(Snapshot& snapshot, const ShotRule& rule) {
  json shot = {{"film", TextOf(rule.film)},
               {"fps", rule.fps},
               {"plate", TextOf(rule.plate)},
               {"mattes", TextOf(rule.mattes)},
               {"clicks", TextOf(rule.clicks)},
               {"holdout", TextOf(rule.holdout)},
               {"shows", json::array()},
               {"frames", json::array()},
               {"width", 0},
               {"height", 0},
               {"problem", ""}};
  for (const ShotRule::Shows& show : rule.shows)
    shot["shows"].push_back({{"frame", show.frame}, {"pose", show.pose.text}});
  try {
    const auto pictures = PicturesOf(Resolved(snapshot, rule.film->text));
    for (const FilmPicture& picture : pictures)
      shot["frames"].push_back(
          {{"frame", picture.frame}, {"name", picture.path.filename().string()}});
    if (pictures.empty()) return shot;
    const ImageInfo first = ReadImageInfo(pictures.front().path);
    shot["width"] = first.width;
    shot["height"] = first.height;
  } catch (const Error& error) {
    shot["problem"] = error.what();
  }
  return shot;
}

json LocatedJson(Snapshot& snapshot) {
  const auto file = snapshot.ResultPath("locate", "", "shot");
  if (!file) return nullptr;
  const FilmedShot shot = ReadShot(*file);
  json located = {{"width", shot.camera.width},
                  {"height", shot.camera.height},
                  {"focal_px", shot.camera.fx},
                  {"focal", shot.focal},
                  {"focal_uncertainty", shot.focal_uncertainty},
                  {"still", shot.still},
                  {"has_picture", snapshot.ResultPath("locate", "", "picture").has_value()},
                  {"frames", json::array()}};
  const auto number = [](const auto& value) { return value ? json(*value) : json(); };
  for (const ShotFrame& frame : shot.frames)
    located["frames"].push_back({{"frame", frame.frame},
                                 {"pose", frame.pose},
                                 {"method", frame.method},
                                 {"contour_px", number(frame.contour_px)},
                                 {"iou", number(frame.iou)},
                                 {"inliers", number(frame.inliers)}});
  return located;
}

json FinishedJson(Snapshot& snapshot) {
  const auto folder = snapshot.ResultPath("composite", "", "pictures");
  if (!folder) return nullptr;
  const json made = JsonOfFile(*folder / "composite.json");
  const fs::path video = snapshot.project() / "out/shot/pictures/shot.mp4";
  json finished = {
      {"fps", made.at("fps")},       {"width", made.at("width")},
      {"height", made.at("height")}, {"pictures", made.at("pictures")},
      {"joins", made.at("joins")},   {"has_plate", fs::exists(*folder / "plate.png")},
      {"compared", json::array()},   {"video", fs::exists(video) ? "shot/pictures/shot.mp4" : ""}};
  for (const fs::path file : pipeline::RealDisk().Children(*folder / "compare"))
    if (int number = 0; std::sscanf(file.stem().c_str(), "%d", &number) == 1)
      finished["compared"].push_back(number);
  return finished;
}

/// Where clicks are or will be. @throws UsageError  outside of the project
fs::path ClicksFile(Snapshot& snapshot) {
  const ShotRule& shot = ShotOf(snapshot);
  const fs::path file =
      shot.clicks ? Resolved(snapshot, shot.clicks->text) : snapshot.project() / "clicks.json";
  if (!IsInProject(snapshot, file))
    throw UsageError(fmt::format("the clicks {} are outside of the project", file.string()));
  return file;
}

/// A list of so many finite numbers.
json Numbers(const json& click, const char* name, std::size_t count) {
  const json list = click.value(name, json());
  const bool fine = list.is_array() && list.size() == count &&
                    std::all_of(list.begin(), list.end(), [](const json& number) {
                      return number.is_number() && std::isfinite(number.get<double>());
                    });
  if (!fine) throw UsageError(fmt::format("a click needs '{}': {} numbers", name, count));
  return list;
}

int Index(const json& click, const char* name) {
  const json value = click.value(name, json());
  if (!value.is_number_integer() || value.get<std::int64_t>() < 0 ||
      value.get<std::int64_t>() > 1'000'000'000)
    throw UsageError(fmt::format("a click's '{}' must be a whole number from 0", name));
  return value.get<int>();
}

json ClickFrom(const json& click) {
  if (!click.is_object()) throw UsageError("a click is not an object");
  json written = {{"frame", Index(click, "frame")}, {"pixel", Numbers(click, "pixel", 2)}};
  if (const json name = click.value("name", json()); name.is_string() && name != "")
    written["name"] = name;
  if (click.contains("vertex")) {
    written["vertex"] = Index(click, "vertex");
  } else {
    written["face"] = Index(click, "face");
    written["barycentric"] = Numbers(click, "barycentric", 3);
  }
  return written;
}

json ClicksJson(Snapshot& snapshot) {
  json clicks = {{"revision", ""}, {"clicks", json::array()}, {"problem", ""}};
  try {
    const fs::path file = ClicksFile(snapshot);
    clicks["revision"] = RevisionOf(file);
    if (!fs::is_regular_file(file)) return clicks;
    const json written = JsonOfFile(file);
    for (json click : written.at("clicks")) {
      // Without a frame: that of the first picture.
      if (!click.contains("frame")) click["frame"] = 0;
      clicks["clicks"].push_back(ClickFrom(click));
    }
    if (!ShotOf(snapshot).clicks)
      clicks["problem"] =
          "clicks.json is there, but pipeline.yaml does not name it; the next change does";
  } catch (const Error& error) {
    clicks["problem"] = error.what();
  } catch (const json::exception& error) {
    clicks["problem"] = "the clicks cannot be read: " + JsonFault(error);
  }
  return clicks;
}

/// A click a line: small changes are small in a comparison, too.
std::string ClicksText(const json& clicks) {
  std::string text = "{\"schema\": 1, \"clicks\": [";
  for (std::size_t i = 0; i < clicks.size(); ++i) text += (i ? ",\n  " : "\n  ") + clicks[i].dump();
  return text + "\n]}\n";
}

/// pipeline.yaml names the file of clicks from the first click on, until the last is gone.
void NameClicks(Snapshot& snapshot, bool there) {
  const bool named = ShotOf(snapshot).clicks.has_value();
  if (named == there) return;
  const fs::path file = snapshot.project() / "pipeline.yaml";
  const std::string revision = RevisionOf(file), text = ReadFile(file);
  WritePipelineFile(snapshot.project(), Edited([&] {
                      return there ? WithValue(text, {"shot", "clicks"}, "clicks.json")
                                   : WithoutValue(text, {"shot", "clicks"});
                    }),
                    revision);
}

std::map<int, std::string> ShowsFrom(Snapshot& snapshot, const json& list) {
  std::map<int, std::string> shows;
  for (const json& show : list) {
    const int frame = Index(show, "frame");
    const std::string pose = show.at("pose");
    if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
    if (!shows.emplace(frame, pose).second)
      throw UsageError(fmt::format("frame {} shows two poses", frame));
  }
  if (shows.size() < 2)
    throw UsageError("Say of two frames or more which pose they show: in-betweens go between them");
  return shows;
}

std::string ShowsText(const std::map<int, std::string>& shows) {
  std::string text;
  for (const auto& [frame, pose] : shows)
    text += fmt::format("{}{}: {}", text.empty() ? "" : ", ", frame, YamlScalar(pose));
  return "{" + text + "}";
}

void RequireFilm(Snapshot& snapshot, const std::string& film) {
  const fs::path folder = Resolved(snapshot, film);
  if (!IsInProject(snapshot, folder) || !fs::is_directory(folder))
    throw UsageError(
        fmt::format("'{}' is no folder of the project; copy the film's pictures into one", film));
  if (PicturesOf(folder).size() < 2)
    throw UsageError(fmt::format("'{}' has fewer than two pictures", film));
}

std::map<int, std::string> ShowsOf(const ShotRule& rule) {
  std::map<int, std::string> shows;
  for (const ShotRule::Shows& show : rule.shows) shows[show.frame] = show.pose.text;
  return shows;
}

/// What stays as it is keeps its text.
std::string WithShot(std::string text, const ShotRule& rule, const std::string& film, double fps,
                     const std::map<int, std::string>& shows) {
  const auto put = [&](const char* name, const std::string& value) {
    text = WithValue(text, {"shot", name}, value);
  };
  if (film != TextOf(rule.film)) put("film", YamlScalar(film));
  if (fps != rule.fps) put("fps", fmt::format("{:g}", fps));
  if (shows != ShowsOf(rule)) put("shows", ShowsText(shows));
  return text;
}

/// A line each, as a person would write it.
std::string WithNewShot(const std::string& text, const std::string& film, double fps,
                        const std::map<int, std::string>& shows) {
  const char* gap = text.empty() || text.back() == '\n' ? "" : "\n";
  return fmt::format("{}{}shot:\n  film: {}\n  fps: {:g}\n  shows: {}\n", text, gap,
                     YamlScalar(film), fps, ShowsText(shows));
}

}  // namespace

json ShotJson(Snapshot& snapshot) {
  json page = {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
               {"shot", nullptr},
               {"folders", FilmFolders(snapshot)},
               {"clicks", nullptr},
               {"located", nullptr},
               {"finished", nullptr}};
  if (!snapshot.file().shot) return page;
  page["shot"] = FilmJson(snapshot, *snapshot.file().shot);
  page["clicks"] = ClicksJson(snapshot);
  page["located"] = LocatedJson(snapshot);
  page["finished"] = FinishedJson(snapshot);
  return page;
}

void SaveShot(Snapshot& snapshot, const json& body) {
  const auto& rule = snapshot.file().shot;
  const std::string film = body.at("film");
  const double fps = body.at("fps");
  if (!(fps > 0 && fps <= 1000)) throw UsageError("pictures a second must be above 0");
  const auto shows = ShowsFrom(snapshot, body.at("shows"));
  if (!rule || film != TextOf(rule->film)) RequireFilm(snapshot, film);
  const std::string text = ReadFile(snapshot.project() / "pipeline.yaml");
  const std::string edited = rule ? Edited([&] { return WithShot(text, *rule, film, fps, shows); })
                                  : WithNewShot(text, film, fps, shows);
  WritePipelineFile(snapshot.project(), edited, body.at("revision"));
}

void SaveClicks(Snapshot& snapshot, const json& body) {
  const fs::path file = ClicksFile(snapshot);
  if (RevisionOf(file) != body.at("revision"))
    throw ChangedMeanwhile(file.filename().string() + " was changed elsewhere; it was read again");
  if (body.at("clicks").size() > kMostClicks) throw UsageError("more than 1000 clicks");
  json clicks = json::array();
  for (const json& click : body.at("clicks")) clicks.push_back(ClickFrom(click));
  if (clicks.empty()) {
    NameClicks(snapshot, false);
    fs::remove(file);
    return;
  }
  fs::create_directories(file.parent_path());
  WriteFileAtomically(file, ClicksText(clicks));
  NameClicks(snapshot, true);
}

fs::path FilmFrameFile(Snapshot& snapshot, int frame) {
  const ShotRule& shot = ShotOf(snapshot);
  for (const FilmPicture& picture : PicturesOf(Resolved(snapshot, shot.film->text)))
    if (picture.frame == frame) return picture.path;
  throw NotFound(fmt::format("the film has no frame {}", frame));
}

fs::path ShotPictureFile(Snapshot& snapshot, const std::string& what, int number) {
  if (what == "located") {
    const auto picture = snapshot.ResultPath("locate", "", "picture");
    if (!picture) throw NotFound("the camera is not found yet");
    return *picture;
  }
  const auto folder = snapshot.ResultPath("composite", "", "pictures");
  if (!folder) throw NotFound("the shot is not made yet");
  if (what == "plate" && fs::exists(*folder / "plate.png")) return *folder / "plate.png";
  const fs::path place = what == "compare" ? *folder / "compare" : *folder;
  const std::string stem = fmt::format("{:04}", number);
  if (what == "compare" || what == "result")
    for (const fs::path file : pipeline::RealDisk().Children(place))
      if (file.stem() == stem && !fs::is_directory(place / file)) return place / file;
  throw NotFound(fmt::format("the shot has no such picture: {} {}", what, number));
}

}  // namespace keypose::studio
