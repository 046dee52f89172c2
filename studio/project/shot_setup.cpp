#include "studio/project/shot_setup.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/pictures/movie_header.h"
#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "studio/project/changes.h"
#include "studio/project/shot_files.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::ShotRule;

namespace {

constexpr int kDeepestFilm = 3, kMostVisited = 4000;
constexpr std::size_t kMostOffers = 400;

int PictureCount(const fs::path& folder) {
  try {
    return static_cast<int>(PicturesOf(folder).size());
  } catch (const Error&) {
    return 0;
  }
}

bool IsVideoName(const fs::path& file) {
  return LowerExtension(file) == ".mp4" || LowerExtension(file) == ".mov";
}

/// The list of offers that a file belongs to; null: none.
const char* OfferOf(const fs::path& file) {
  if (IsVideoName(file)) return "videos";
  if (IsReadableMeshName(file)) return "meshes";
  return IsPhotographName(file) ? "pictures" : nullptr;
}

/// Walks through the project's folders, but not into those of its own making.
class Offers {
 public:
  explicit Offers(const fs::path& project) : project_(project) { Visit(project, 0); }
  json Take() {
    for (auto& [name, list] : lists_.items())
      std::sort(list.begin(), list.end(), [](const json& a, const json& b) {
        return a.is_object() ? a["path"] < b["path"] : a < b;
      });
    return std::move(lists_);
  }

 private:
  void Visit(const fs::path& folder, int depth) {
    std::error_code ignored;
    const int numbered = depth > 0 ? PictureCount(folder) : 0;
    if (numbered > 1) Add("folders", {{"path", PathOf(folder)}, {"pictures", numbered}});
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
      const fs::path& path = entry.path();
      const std::string name = path.filename().string();
      if (name.starts_with(".") || !IsValidUtf8(name) || entry.is_symlink(ignored)) continue;
      if (++visited_ > kMostVisited) return;
      if (entry.is_directory(ignored)) {
        if (depth < kDeepestFilm && !(depth == 0 && IsOwn(name))) Visit(path, depth + 1);
      } else if (const char* list = OfferOf(path); list && !(numbered > 1 && IsPicture(list))) {
        Add(list, PathOf(path));
      }
    }
  }
  static bool IsOwn(const std::string& name) {
    static const std::set<std::string> kOwn = {"out",       "photos",  "masks",
                                               "landmarks", "results", "node_modules"};
    return kOwn.contains(name);
  }
  static bool IsPicture(const std::string& list) { return list == "pictures"; }
  std::string PathOf(const fs::path& path) const {
    return path.lexically_relative(project_).generic_string();
  }
  void Add(const char* list, json offer) {
    if (lists_[list].size() < kMostOffers) lists_[list].push_back(std::move(offer));
  }

  fs::path project_;
  int visited_ = 0;
  json lists_ = {{"folders", json::array()},
                 {"videos", json::array()},
                 {"pictures", json::array()},
                 {"meshes", json::array()}};
};

std::map<int, std::string> ShowsFrom(Snapshot& snapshot, const json& list) {
  std::map<int, std::string> shows;
  for (const json& show : list) {
    const int frame = WholeField(show, "frame");
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

/// A part of the shot that may be named beside its film.
struct Part {
  const char* name;
  bool picture, pictures, mesh;  ///< what it may be: one picture; a folder or video; a mesh
  const char* kinds;
};
constexpr Part kParts[] = {
    {"plate", true, true, false,
     "a picture, a folder of numbered pictures or a video (.mp4, .mov)"},
    {"mattes", false, true, false, "a folder of numbered pictures or a video (.mp4, .mov)"},
    {"holdout", true, false, false, "a picture"},
    {"set", false, false, true, "a mesh (.ply, .obj, .off, .stl, .glb, .gltf)"}};

bool IsOfKind(const Part& part, const fs::path& path) {
  if (fs::is_directory(path)) return part.pictures && PictureCount(path) > 1;
  if (!fs::is_regular_file(path)) return false;
  if (IsVideoName(path)) return part.pictures && IsMovie(path);
  return (part.picture && IsPhotographName(path)) || (part.mesh && IsReadableMeshName(path));
}

void RequirePart(Snapshot& snapshot, const Part& part, const std::string& text) {
  const fs::path path = Resolved(snapshot, text);
  if (!IsInProject(snapshot, path))
    throw UsageError(
        fmt::format("{}: '{}' is outside of the project; copy it in", part.name, text));
  if (!IsOfKind(part, path))
    throw UsageError(fmt::format("{}: '{}' is not {}", part.name, text, part.kinds));
}

/// A film of plates passes with the camera; one picture cannot.
void RequirePassingPlate(Snapshot& snapshot, const std::string& plate, const std::string& camera) {
  if (camera != "moving" || plate.empty()) return;
  const fs::path path = Resolved(snapshot, plate);
  if (fs::is_regular_file(path) && !IsVideoName(path))
    throw UsageError(fmt::format(
        "plate: '{}' is one picture, but the camera moves: name a folder or a video of plates, one "
        "for each filmed frame or for each picture of the finished shot",
        plate));
}

/// What the shot will be.
struct Wanted {
  std::string film, camera;
  double fps = 12;
  std::map<int, std::string> shows;
  std::map<std::string, std::string> parts;  ///< by name; all of kParts
};

/// @param rule  as it is; null: there is no shot yet
Wanted WantedOf(Snapshot& snapshot, const ShotRule* rule, const json& body) {
  Wanted wanted;
  wanted.film = body.at("film");
  wanted.fps = body.at("fps");
  if (!(wanted.fps > 0 && wanted.fps <= 1000))
    throw UsageError("pictures a second must be above 0");
  wanted.shows = ShowsFrom(snapshot, body.at("shows"));
  if (!rule || wanted.film != TextOf(rule->Given("film"))) RequireFilm(snapshot, wanted.film);
  for (const Part& part : kParts) {
    const std::string now = rule ? TextOf(rule->Given(part.name)) : "";
    const std::string text = body.value(part.name, now);
    if (text != now && !text.empty()) RequirePart(snapshot, part, text);
    wanted.parts[part.name] = text;
  }
  wanted.camera = body.value("camera", ShotCamera(snapshot));
  if (wanted.camera != "still" && wanted.camera != "moving")
    throw UsageError(fmt::format("a camera is still or moving, not '{}'", wanted.camera));
  if (body.contains("camera") || body.contains("plate"))
    RequirePassingPlate(snapshot, wanted.parts["plate"], wanted.camera);
  return wanted;
}

/// What stays as it is keeps its text.
std::string WithShot(std::string text, const ShotRule& rule, const Wanted& wanted) {
  const auto put = [&](const char* name, const std::string& value) {
    text = WithValue(text, {"shot", name}, value);
  };
  if (wanted.film != TextOf(rule.Given("film"))) put("film", YamlScalar(wanted.film));
  if (wanted.fps != rule.fps) put("fps", fmt::format("{:g}", wanted.fps));
  if (wanted.shows != ShowsOf(rule)) put("shows", ShowsText(wanted.shows));
  for (const Part& part : kParts) {
    const std::string& path = wanted.parts.at(part.name);
    if (path == TextOf(rule.Given(part.name))) continue;
    if (path.empty())
      text = WithoutValue(text, {"shot", part.name});
    else
      put(part.name, YamlScalar(path));
  }
  return text;
}

/// A line each, as a person would write it.
std::string WithNewShot(const std::string& text, const Wanted& wanted) {
  const char* gap = text.empty() || text.back() == '\n' ? "" : "\n";
  std::string shot = fmt::format("{}{}shot:\n  film: {}\n  fps: {:g}\n  shows: {}\n", text, gap,
                                 YamlScalar(wanted.film), wanted.fps, ShowsText(wanted.shows));
  for (const Part& part : kParts)
    if (const std::string& path = wanted.parts.at(part.name); !path.empty())
      shot += fmt::format("  {}: {}\n", part.name, YamlScalar(path));
  return shot;
}

/// A camera that stands still needs no word, as that is the default.
std::string WithCamera(Snapshot& snapshot, const std::string& text, const std::string& camera) {
  if (camera == ShotCamera(snapshot)) return text;
  const YamlPath path = {"options", "locate", "camera"};
  const auto locate = snapshot.file().options.find("locate");
  const bool named =
      locate != snapshot.file().options.end() && locate->second.options.contains("camera");
  if (camera == "still" && named) return WithoutValue(text, path);
  return WithValue(text, path, camera);
}

}  // namespace

json ShotOffersJson(Snapshot& snapshot) { return Offers(snapshot.project()).Take(); }

std::string ShotCamera(Snapshot& snapshot) {
  const pipeline::Step* step = snapshot.FindStep("locate", "");
  if (!step) return "still";
  const auto camera = step->options.find("camera");
  return camera == step->options.end() ? "still" : camera->second;
}

void SaveShot(Snapshot& snapshot, const json& body) {
  const auto& shot = snapshot.file().shot;
  const ShotRule* rule = shot ? &*shot : nullptr;
  const Wanted wanted = WantedOf(snapshot, rule, body);
  const std::string text = ReadFile(snapshot.project() / "pipeline.yaml");
  const std::string edited = Edited([&] {
    const std::string with = rule ? WithShot(text, *rule, wanted) : WithNewShot(text, wanted);
    return WithCamera(snapshot, with, wanted.camera);
  });
  WritePipelineFile(snapshot.project(), edited, body.at("revision"));
}

}  // namespace keypose::studio
