#include "studio/project/timeline.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/timeline.h"
#include "pipeline/timeline_yaml.h"
#include "studio/project/changes.h"
#include "studio/project/yaml_edit.h"

namespace keypose::studio {

using nlohmann::json;

namespace {

/// Seconds between two keys of a timeline without times: `steps` frames between them.
double GapOf(Snapshot& snapshot) {
  const pipeline::Step* step = snapshot.FindStep("interpolate", "");
  int between = 9;
  if (step && step->options.contains("steps")) between = std::stoi(step->options.at("steps"));
  return (between + 1) / snapshot.file().fps;
}

json KeysInOrder(Snapshot& snapshot) {
  json keys = json::array();
  const double gap = GapOf(snapshot);
  for (const std::string& pose : snapshot.graph().keys)
    keys.push_back({{"pose", pose}, {"at", gap * static_cast<double>(keys.size())}});
  return keys;
}

/// A number in the fewest digits, so that the file reads well: frames are thirds of a hundredth.
std::string NumberText(double value) {
  const double rounded = std::round(value * 1e6) / 1e6;
  return fmt::format("{}", rounded == 0 ? 0.0 : rounded);
}

std::string FlowText(const json& value) {
  if (value.is_string()) return YamlScalar(value.get<std::string>());
  if (value.is_number_float()) return NumberText(value.get<double>());
  if (value.is_array()) {
    std::string text;
    for (const json& item : value) text += (text.empty() ? "" : ", ") + FlowText(item);
    return "[" + text + "]";
  }
  if (value.is_object()) {
    std::string text;
    for (const auto& [key, item] : value.items())
      text += (text.empty() ? "" : ", ") + YamlScalar(key) + ": " + FlowText(item);
    return "{" + text + "}";
  }
  return value.dump();
}

/// {pose: rest, at: 0, hold: 0.5}: pose and time come first, then the rest by name.
std::string KeyText(const json& key) {
  std::string text =
      fmt::format("{{pose: {}, at: {}", YamlScalar(key.at("pose").get<std::string>()),
                  NumberText(key.at("at").get<double>()));
  for (const auto& [name, value] : key.items()) {
    if (name == "pose" || name == "at" || value.is_null()) continue;
    if (name == "hold" && value == 0) continue;
    text += fmt::format(", {}: {}", YamlScalar(name), FlowText(value));
  }
  return text + "}";
}

/// The file's text with one setting of the timeline; null takes it out.
std::string WithSetting(const std::string& text, const std::string& name, const json& value) {
  const YamlPath path = {"timeline", name};
  return value.is_null() ? WithoutValue(text, path) : WithValue(text, path, FlowText(value));
}

/// A timeline that is only a list becomes a map with the list under `keys`.
std::string AsMap(const std::string& text, const std::vector<std::string>& keys) {
  const YAML::Node timeline = YAML::Load(text)["timeline"];
  if (timeline && timeline.IsMap()) return text;
  std::string list;
  for (const std::string& key : keys) list += "\n    - " + key;
  const std::string without = WithoutValue(text, {"timeline"});
  const std::string gap = without.empty() || without.back() == '\n' ? "" : "\n";
  return without + gap + "timeline:\n  keys:" + list + "\n";
}

void CheckTimeline(const std::string& text) {
  const YAML::Node root = YAML::Load(text);
  const double fps = root["fps"] ? root["fps"].as<double>() : 24;
  const std::string parsed = pipeline::TimelineJson(root["timeline"], fps);
  if (!parsed.empty()) ParseTimeline(parsed, "the timeline");
}

void CheckPoses(Snapshot& snapshot, const json& keys) {
  if (keys.size() < 2) throw UsageError("a timeline needs two keys or more");
  for (const json& key : keys) {
    const std::string pose = key.at("pose");
    if (!snapshot.HasPose(pose)) throw UsageError(fmt::format("there is no pose '{}'", pose));
  }
}

std::string WithTimeline(Snapshot& snapshot, const json& timeline) {
  std::string text = ReadFile(snapshot.project() / "pipeline.yaml");
  std::vector<std::string> keys;
  for (const json& key : timeline.at("keys")) keys.push_back(KeyText(key));
  text = AsMap(text, keys);
  text = WithItems(text, {"timeline", "keys"}, keys);
  const bool loop = timeline.value("loop", false);
  const int step = timeline.value("step", 1);
  text = WithSetting(text, "loop", loop ? json(true) : json());
  text = WithSetting(text, "step", step > 1 ? json(step) : json());
  const double fps = timeline.value("fps", snapshot.file().fps);
  if (fps != snapshot.file().fps) text = WithValue(text, {"fps"}, NumberText(fps));
  return text;
}

}  // namespace

json TimelineToPage(Snapshot& snapshot) {
  json page = {{"revision", RevisionOf(snapshot.project() / "pipeline.yaml")},
               {"fps", snapshot.file().fps},
               {"loop", false},
               {"step", 1},
               {"timed", false},
               {"other", json::object()}};
  const std::string& written = snapshot.graph().timeline_json;
  const json parsed = written.empty() ? json::object() : json::parse(written);
  page["keys"] = json::array();
  for (json key : parsed.value("keys", json::array())) {
    if (!key.contains("time")) break;
    page["timed"] = true;
    key["at"] = key["time"];
    key.erase("time");
    page["keys"].push_back(key);
  }
  if (page["keys"].empty()) page["keys"] = KeysInOrder(snapshot);
  for (const auto& [name, value] : parsed.items()) {
    if (name == "loop" || name == "step")
      page[name] = value;
    else if (name != "keys" && name != "fps" && name != "schema")
      page["other"][name] = value;
  }
  return page;
}

void SaveTimeline(Snapshot& snapshot, const json& timeline) {
  CheckPoses(snapshot, timeline.at("keys"));
  std::string text;
  try {
    text = WithTimeline(snapshot, timeline);
  } catch (const YamlEditError& error) {
    throw UsageError(fmt::format("pipeline.yaml cannot be changed from here: {}", error.what()));
  }
  CheckTimeline(text);
  WritePipelineFile(snapshot.project(), text, timeline.at("revision"));
}

}  // namespace keypose::studio
