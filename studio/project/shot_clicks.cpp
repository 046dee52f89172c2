#include "studio/project/shot_clicks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/project/shot_io.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"
#include "studio/project/changes.h"
#include "studio/project/shot_files.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;
using pipeline::ShotRule;

namespace {

constexpr std::size_t kMostClicks = 1000, kClicksForAPlace = 4;
/// Answers whose files are there at the same time.
constexpr int kQuickAnswers = 8;

/// Where clicks are or will be. @throws UsageError  outside of the project
fs::path ClicksFile(Snapshot& snapshot) {
  const ShotRule& shot = ShotOf(snapshot);
  const auto* given = shot.Given("clicks");
  const fs::path file =
      given ? Resolved(snapshot, given->text) : snapshot.project() / "clicks.json";
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

json ClickFrom(const json& click) {
  if (!click.is_object()) throw UsageError("a click is not an object");
  json written = {{"frame", WholeField(click, "frame")}, {"pixel", Numbers(click, "pixel", 2)}};
  if (const json name = click.value("name", json()); name.is_string() && name != "")
    written["name"] = name;
  if (click.contains("vertex")) {
    written["vertex"] = WholeField(click, "vertex");
  } else {
    written["face"] = WholeField(click, "face");
    written["barycentric"] = Numbers(click, "barycentric", 3);
  }
  return written;
}

/// The clicks of a file. @throws InputError  it, or one of them, cannot be read
json ClicksIn(const fs::path& file) {
  json clicks = json::array();
  if (!fs::is_regular_file(file)) return clicks;
  const std::string name = file.filename().string();
  try {
    const json written = JsonOfFile(file);
    for (json click : written.at("clicks")) {
      // Without a frame: that of the first picture.
      if (!click.contains("frame")) click["frame"] = 0;
      clicks.push_back(ClickFrom(click));
    }
  } catch (const UsageError& error) {
    throw InputError(fmt::format("{}: click {}: {}", name, clicks.size() + 1, error.what()));
  } catch (const json::exception& error) {
    throw InputError(fmt::format("{}: the clicks cannot be read: {}", name, JsonFault(error)));
  }
  return clicks;
}

/// The page does not show what cannot be read, so it would be lost.
void RequireReadable(const fs::path& file) {
  try {
    ClicksIn(file);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}; mend or delete it in an editor first", error.what()));
  }
}

/// A click a line: small changes are small in a comparison, too.
std::string ClicksText(const json& clicks) {
  std::string text = "{\"schema\": 1, \"clicks\": [";
  for (std::size_t i = 0; i < clicks.size(); ++i) text += (i ? ",\n  " : "\n  ") + clicks[i].dump();
  return text + "\n]}\n";
}

/// pipeline.yaml names the file of clicks from the first click on, until the last is gone.
void NameClicks(Snapshot& snapshot, bool there) {
  const bool named = ShotOf(snapshot).Given("clicks") != nullptr;
  if (named == there) return;
  const fs::path file = snapshot.project() / "pipeline.yaml";
  const std::string revision = RevisionOf(file), text = ReadFile(file);
  WritePipelineFile(snapshot.project(), Edited([&] {
                      return there ? WithValue(text, {"shot", "clicks"}, "clicks.json")
                                   : WithoutValue(text, {"shot", "clicks"});
                    }),
                    revision);
}

/// The clicks of one frame. @throws UsageError  too few
json ClicksOfFrame(Snapshot& snapshot, int frame) {
  json clicks = json::array();
  const json all = ClicksJson(snapshot).at("clicks");
  for (const json& click : all)
    if (click.at("frame") == frame) clicks.push_back(click);
  if (clicks.size() < kClicksForAPlace)
    throw UsageError(fmt::format("frame {} has {} clicks; four are needed", frame, clicks.size()));
  return clicks;
}

/// The pose that a frame shows. @throws UsageError  none
std::string PoseOfFrame(const ShotRule& shot, int frame) {
  for (const ShotRule::Shows& show : shot.shows)
    if (show.frame == frame) return show.pose.text;
  throw UsageError(fmt::format("frame {} shows no pose", frame));
}

}  // namespace

json ClicksJson(Snapshot& snapshot) {
  json clicks = {{"revision", ""}, {"clicks", json::array()}, {"problem", ""}};
  try {
    const fs::path file = ClicksFile(snapshot);
    clicks["revision"] = RevisionOf(file);
    if (!fs::is_regular_file(file)) return clicks;
    clicks["clicks"] = ClicksIn(file);
    if (!ShotOf(snapshot).Given("clicks"))
      clicks["problem"] =
          "clicks.json is there, but pipeline.yaml does not name it; the next change does";
  } catch (const Error& error) {
    clicks["problem"] = error.what();
  }
  return clicks;
}

void SaveClicks(Snapshot& snapshot, const json& body) {
  const fs::path file = ClicksFile(snapshot);
  if (RevisionOf(file) != body.at("revision"))
    throw ChangedMeanwhile(file.filename().string() + " was changed elsewhere; it was read again");
  RequireReadable(file);
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

QuickFiles QuickFilesOf(const fs::path& project, int number) {
  const fs::path folder = project / ".keypose/studio/quick";
  const int slot = number % kQuickAnswers;
  return {folder / fmt::format("clicks_{}.json", slot), folder / fmt::format("shot_{}.json", slot),
          folder / fmt::format("located_{}.png", slot)};
}

std::vector<std::string> QuickLocateFlags(Snapshot& snapshot, int frame, const QuickFiles& files) {
  constexpr const char* kPictureSize = "1280";  // as large as a page shows it
  const ShotRule& shot = ShotOf(snapshot);
  const std::string pose = PoseOfFrame(shot, frame);
  const auto mesh = snapshot.MeshPath(pose, MeshKind::kMesh);
  if (!mesh) throw UsageError(fmt::format("pose '{}' has no mesh yet", pose));
  fs::create_directories(files.clicks.parent_path());
  WriteFileAtomically(files.clicks, ClicksText(ClicksOfFrame(snapshot, frame)));
  std::vector<std::string> flags = {
      "--quick",    "true",
      "--mesh",     mesh->string(),
      "--plate",    Resolved(snapshot, shot.Given("film")->text).string(),
      "--clicks",   files.clicks.string(),
      "--poses",    pose,
      "--shows",    fmt::format("{}={}", frame, pose),
      "--max_size", kPictureSize,
      "--shot",     files.shot.string(),
      "--picture",  files.picture.string()};
  if (const auto* mattes = shot.Given("mattes"))
    flags.insert(flags.end(), {"--matte", Resolved(snapshot, mattes->text).string()});
  // The lens as the whole work will take it.
  if (const pipeline::Step* step = snapshot.FindStep("locate", ""))
    for (const char* option : {"focal_35mm", "distortion"})
      if (const auto set = step->options.find(option); set != step->options.end())
        flags.insert(flags.end(), {fmt::format("--{}", option), set->second});
  return flags;
}

json QuicklyLocatedJson(const QuickFiles& files) {
  const FilmedShot shot = ReadShot(files.shot);
  const ShotFrame& frame = shot.frames.front();
  const auto number = [](const auto& value) { return value ? json(*value) : json(); };
  return {{"focal_px", shot.camera.fx},
          {"focal", shot.focal},
          {"contour_px", number(frame.contour_px)},
          {"iou", number(frame.iou)}};
}

}  // namespace keypose::studio
