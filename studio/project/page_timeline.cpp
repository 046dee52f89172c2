#include "studio/project/page_timeline.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/project/timeline_json.h"
#include "core/io/text/files.h"
#include "core/io/text/yaml_edit.h"
#include "core/values/errors.h"
#include "pipeline/graph/timeline_yaml.h"
#include "studio/project/changes.h"
#include "studio/project/picks.h"

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

/// Keys with what the file says of them, and with the times that `interpolate` gives those of which
/// it only tells the order: `steps` frames between two, after the first one's hold.
json KeysWithTimes(Snapshot& snapshot, json keys) {
  if (keys.empty())
    for (const std::string& pose : snapshot.graph().keys) keys.push_back({{"pose", pose}});
  const double gap = GapOf(snapshot), fps = snapshot.file().fps;
  double next = 0;
  for (json& key : keys) {
    key["at"] = key.value("time", next);
    key.erase("time");
    const json hold = key.value("hold", json());
    next += gap + (hold.is_number() ? std::round(hold.get<double>() * fps) / fps : 0);
  }
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

/// A timeline that is only a list becomes a map with the list under `keys`. Where the file has
/// none, it gets one, with the pace that the project had without it.
std::string AsMap(const std::string& text, const std::vector<std::string>& keys,
                  const json& before) {
  const YAML::Node timeline = YAML::Load(text)["timeline"];
  if (timeline && timeline.IsMap()) return text;
  if (timeline && timeline.IsSequence()) return WithListUnder(text, {"timeline"}, "keys");
  std::string list;
  for (const std::string& key : keys) list += "\n    - " + key;
  const std::string without = WithoutValue(text, {"timeline"});
  const std::string gap = without.empty() || without.back() == '\n' ? "" : "\n";
  const std::string whole = without + gap + "timeline:\n  keys:" + list + "\n";
  return WithSetting(whole, "interpolation", before.value("interpolation", json()));
}

/// Names of the regions that pins, paths and turns are about.
std::set<std::string> UsedRegions(const json& keys, const json& other) {
  std::set<std::string> used;
  for (const char* name : {"pins", "trajectories"}) {
    const json items = other.value(name, json::array());
    for (const json& item : items) used.insert(item.at("region"));
  }
  for (const json& key : keys) {
    const json turns = key.value("turns", json::object());
    for (const auto& [region, count] : turns.items()) used.insert(region);
  }
  return used;
}

/// The timeline's regions, with the painted ones that are used and without those that are not.
json WithPainted(const json& regions, const json& painted, const std::set<std::string>& used) {
  json all = json::array();
  std::set<std::string> there;
  for (json region : regions) {
    const std::string name = region.at("name");
    if (region.contains("vertices") && painted.contains(name)) {
      if (!used.contains(name)) continue;
      region["vertices"] = painted[name];
    }
    there.insert(name);
    all.push_back(region);
  }
  for (const std::string& name : used)
    if (!there.contains(name) && painted.contains(name))
      all.push_back({{"name", name}, {"vertices", painted[name]}});
  return all;
}

/// A list of the timeline; one that has not changed keeps its text.
std::string WithList(const std::string& text, const std::string& name, const json& before,
                     const json& after) {
  if (before == after) return text;
  return WithSetting(text, name, after.empty() ? json() : after);
}

/// By name. Without those of a file that cannot be read: it holds up the page that paints them, not
/// the timeline.
json PaintedRegions(Snapshot& snapshot) {
  try {
    return RegionsJson(snapshot).at("regions");
  } catch (const InputError&) {
    return json::object();
  }
}

/// What the timeline said until now; of a filmed shot without one, what its frames say.
json TimelineOf(Snapshot& snapshot) {
  const std::string& written = snapshot.graph().timeline_json;
  return written.empty() ? json::object() : json::parse(written);
}

/// Pins as the page has them, and the painted regions that they and the turns need.
std::string WithRules(Snapshot& snapshot, const std::string& text, const json& timeline) {
  const json before = TimelineOf(snapshot);
  const json none = json::array(), other = timeline.value("other", json::object());
  const json painted = PaintedRegions(snapshot);
  const json regions = before.value("regions", none);
  const std::set<std::string> used = UsedRegions(timeline.at("keys"), other);
  const std::string with_pins =
      WithList(text, "pins", before.value("pins", none), other.value("pins", none));
  return WithList(with_pins, "regions", regions, WithPainted(regions, painted, used));
}

void CheckTimeline(const std::string& text) {
  const YAML::Node root = YAML::Load(text);
  const double fps = root["fps"] ? root["fps"].as<double>() : 24;
  const std::string parsed = pipeline::TimelineJson(root["timeline"], fps);
  if (!parsed.empty()) RequirePlayable(ParseTimeline(parsed, "the timeline"), "the timeline");
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
  text = AsMap(text, keys, TimelineOf(snapshot));
  text = WithItems(text, {"timeline", "keys"}, keys);
  const bool loop = timeline.value("loop", false);
  const int step = timeline.value("step", 1);
  text = WithSetting(text, "loop", loop ? json(true) : json());
  text = WithSetting(text, "step", step > 1 ? json(step) : json());
  text = WithRules(snapshot, text, timeline);
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
  const json parsed = TimelineOf(snapshot), keys = parsed.value("keys", json::array());
  page["timed"] = !keys.empty() && keys.front().contains("time");
  page["keys"] = KeysWithTimes(snapshot, keys);
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
  const std::string text = Edited([&] { return WithTimeline(snapshot, timeline); });
  CheckTimeline(text);
  WritePipelineFile(snapshot.project(), text, timeline.at("revision"));
}

void FollowPaintedRegions(Snapshot& snapshot, const json& painted) {
  const json before = TimelineOf(snapshot);
  if (before.empty()) return;
  const json regions = before.value("regions", json::array());
  const std::set<std::string> used = UsedRegions(before.at("keys"), before);
  const json after = WithPainted(regions, painted, used);
  if (after == regions) return;
  const std::filesystem::path file = snapshot.project() / "pipeline.yaml";
  const std::string text =
      Edited([&] { return WithList(ReadFile(file), "regions", regions, after); });
  CheckTimeline(text);
  WritePipelineFile(snapshot.project(), text, RevisionOf(file));
}

}  // namespace keypose::studio
