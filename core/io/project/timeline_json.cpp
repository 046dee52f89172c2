#include "core/io/project/timeline_json.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/io/text/files.h"

namespace keypose {
namespace {

using nlohmann::json;

const std::vector<std::string> kTravelNames = {"stepped", "linear", "smooth"};

std::string Shown(const json& value) {
  const std::string text = value.dump();
  return text.size() <= 40 ? text : text.substr(0, 37) + "...";
}

/// A JSON object whose fields are taken by name. Fields that are left at the end are an error.
class Fields {
 public:
  Fields(const json& object, std::string where, int key)
      : object_(object), where_(std::move(where)), key_(key) {
    if (!object.is_object())
      throw TimelineError(where_ + " must be an object of fields, but is " + Shown(object), key_);
  }

  [[noreturn]] void Fail(const std::string& field, const std::string& message) const {
    throw TimelineError(fmt::format("{}: field '{}' {}", where_, field, message), key_);
  }
  [[noreturn]] void Fail(const std::string& message) const {
    throw TimelineError(where_ + " " + message, key_);
  }

  /// The value, or null when absent.
  const json* Take(const std::string& field) {
    known_.push_back(field);
    const auto at = object_.find(field);
    return at == object_.end() || at->is_null() ? nullptr : &*at;
  }

  std::optional<double> Number(const std::string& field, double low, double high) {
    const json* value = Take(field);
    if (!value) return std::nullopt;
    if (!value->is_number() || !std::isfinite(value->get<double>()))
      Fail(field, "is " + Shown(*value) + ", but it must be a number");
    const double number = value->get<double>();
    if (number < low || number > high)
      Fail(field, fmt::format("is {:g}, but it must lie in [{:g}, {:g}]", number, low, high));
    return number;
  }

  std::optional<int> Whole(const std::string& field, int low, int high) {
    const std::optional<double> number = Number(field, low, high);
    if (number && *number != std::round(*number))
      Fail(field, fmt::format("is {:g}, but it must be a whole number", *number));
    return number ? std::optional<int>(static_cast<int>(*number)) : std::nullopt;
  }

  std::optional<bool> Bool(const std::string& field) {
    const json* value = Take(field);
    if (value && !value->is_boolean())
      Fail(field, "is " + Shown(*value) + ", but it must be true or false");
    return value ? std::optional<bool>(value->get<bool>()) : std::nullopt;
  }

  std::optional<std::string> Text(const std::string& field) {
    const json* value = Take(field);
    if (value && !value->is_string())
      Fail(field, "is " + Shown(*value) + ", but it must be a word");
    return value ? std::optional<std::string>(value->get<std::string>()) : std::nullopt;
  }

  std::optional<Eigen::Vector3d> Point(const std::string& field) {
    const json* value = Take(field);
    if (!value) return std::nullopt;
    Eigen::Vector3d point;
    if (!value->is_array() || value->size() != 3) Fail(field, "must be three numbers [x, y, z]");
    for (int k = 0; k < 3; ++k) {
      if (!(*value)[k].is_number() || !std::isfinite((*value)[k].get<double>()))
        Fail(field, "must be three numbers [x, y, z]");
      point[k] = (*value)[k].get<double>();
    }
    return point;
  }

  /// Calls `item(fields)` for each object of a list.
  template <class F>
  void List(const std::string& field, const std::string& what, const F& item) {
    const json* value = Take(field);
    if (!value) return;
    if (!value->is_array()) Fail(field, "must be a list");
    for (std::size_t i = 0; i < value->size(); ++i) {
      Fields fields((*value)[i], fmt::format("{}: {} {}", where_, what, i), key_);
      item(fields);
      fields.Done();
    }
  }

  void Done() const {
    for (const auto& [field, value] : object_.items()) {
      if (std::find(known_.begin(), known_.end(), field) != known_.end()) continue;
      const std::string nearest = NearestWord(field, known_);
      Fail(fmt::format("has no field '{}'{}", field,
                       nearest.empty() ? "" : "; did you mean '" + nearest + "'?"));
    }
  }

  const std::string& where() const { return where_; }
  int key() const { return key_; }

 private:
  const json& object_;
  std::string where_;
  int key_;
  std::vector<std::string> known_;
};

std::optional<Travel> TakeTravel(Fields& fields) {
  const auto name = fields.Text("interpolation");
  if (!name) return std::nullopt;
  const auto at = std::find(kTravelNames.begin(), kTravelNames.end(), *name);
  if (at == kTravelNames.end())
    fields.Fail("interpolation",
                fmt::format("is '{}'; it can be stepped, linear or smooth", *name));
  return static_cast<Travel>(at - kTravelNames.begin());
}

std::optional<Ease> TakeEase(Fields& fields) {
  const json* value = fields.Take("ease");
  if (!value) return std::nullopt;
  if (value->is_string()) {
    const std::string name = value->get<std::string>();
    if (const auto ease = EaseNamed(name)) return ease;
    fields.Fail("ease",
                fmt::format("is '{}'; it can be linear, ease, in, out, in-out, or four numbers "
                            "[x1, y1, x2, y2] as in CSS's "
                            "cubic-bezier; did you mean '{}'?",
                            name, NearestWord(name, {"linear", "ease", "in", "out", "in-out"})));
  }
  const auto number = [](const json& v) { return v.is_number() && std::isfinite(v.get<double>()); };
  if (!value->is_array() || value->size() != 4 ||
      !std::all_of(value->begin(), value->end(), number))
    fields.Fail("ease",
                "is " + Shown(*value) + ", but it must be a word or four numbers [x1, y1, x2, y2]");
  const Ease ease{(*value)[0], (*value)[1], (*value)[2], (*value)[3]};
  if (std::min(ease.x1, ease.x2) < 0 || std::max(ease.x1, ease.x2) > 1)
    fields.Fail("ease", "has x1 or x2 outside [0, 1], so that time would run backwards");
  if (std::min(ease.y1, ease.y2) < -2 || std::max(ease.y1, ease.y2) > 3)
    fields.Fail("ease", "has y1 or y2 outside [-2, 3]");
  return ease;
}

TimelineTurn TakeTurn(Fields& fields, const std::string& region, const json& value) {
  const auto whole = [](const json& v) {
    return v.is_number_integer() && std::abs(v.get<double>()) <= 100;
  };
  if (whole(value)) return {value.get<int>(), Eigen::Vector3d::Zero()};
  if (!value.is_object())
    fields.Fail("turns",
                fmt::format("gives region '{}' {}, but turns are whole numbers from -100 to 100",
                            region, Shown(value)));
  Fields turn(value, fmt::format("{}: turns of '{}'", fields.where(), region), fields.key());
  const auto count = turn.Whole("turns", -100, 100);
  const auto axis = turn.Point("axis");
  turn.Done();
  if (!count) turn.Fail("give no number of turns, as in {\"turns\": 1, \"axis\": [0, 0, 1]}");
  if (axis && !(axis->norm() > 0)) turn.Fail("axis", "has no length");
  return {*count, axis.value_or(Eigen::Vector3d::Zero())};
}

void TakeTurns(Fields& fields, TimelineKey& key) {
  const json* turns = fields.Take("turns");
  if (!turns) return;
  if (!turns->is_object())
    fields.Fail("turns", "must name regions and whole turns, as in {\"propeller\": 1}");
  for (const auto& [region, value] : turns->items())
    key.turns[region] = TakeTurn(fields, region, value);
}

/// Defaults for the span of a key.
struct SpanDefaults {
  Travel travel = Travel::kSmooth;
  Ease ease;
  int step = 1;
};

TimelineKey TakeKey(Fields& fields, const SpanDefaults& defaults, bool extended) {
  TimelineKey key;
  key.pose = fields.Text("pose").value_or("");
  key.time_s = fields.Number("time", -1e7, 1e7);
  if (!extended) return key;
  key.hold_s = fields.Number("hold", 0, 1e7).value_or(0);
  key.travel = TakeTravel(fields).value_or(defaults.travel);
  key.ease = TakeEase(fields).value_or(defaults.ease);
  key.step = fields.Whole("step", 1, 1000).value_or(defaults.step);
  TakeTurns(fields, key);
  return key;
}

void TakeRegion(Fields& fields, Timeline& timeline) {
  TimelineRegion region;
  region.name = fields.Text("name").value_or("");
  if (region.name.empty()) fields.Fail("has no name; pins, trajectories and turns use it");
  if (timeline.FindRegion(region.name))
    fields.Fail("name", fmt::format("'{}' is there twice", region.name));
  const auto center = fields.Point("center");
  const auto radius = fields.Number("radius", 0, 1e12);
  if (const json* vertices = fields.Take("vertices")) {
    if (center || radius) fields.Fail("has both vertices and a ball; give one of them");
    if (!vertices->is_array() || vertices->empty())
      fields.Fail("vertices", "must be a list of vertex numbers, counted from 0");
    for (const json& v : *vertices) {
      if (!v.is_number_integer() || v.get<double>() < 0 || v.get<double>() > 2e9)
        fields.Fail("vertices", "holds " + Shown(v));
      region.vertices.push_back(v.get<int>());
    }
  } else {
    if (!center || !radius || !(*radius > 0))
      fields.Fail("needs vertices, or a center [x, y, z] and a radius above 0");
    region.center = *center;
    region.radius = *radius;
  }
  timeline.regions.push_back(region);
}

std::string TakeRegionName(Fields& fields) {
  const auto name = fields.Text("region");
  if (!name) fields.Fail("names no region");
  return *name;
}

void TakeVolume(Fields& fields, Timeline& timeline) {
  const json* value = fields.Take("volume");
  if (!value) return;
  if (value->is_boolean()) {
    timeline.keep_volume = value->get<bool>();
    return;
  }
  if (!value->is_array())
    fields.Fail("volume", "must be true, false, or a list as in [{\"time\": 0.5, \"ratio\": 0.9}]");
  timeline.keep_volume = true;
  fields.List("volume", "volume", [&](Fields& item) {
    const auto time = item.Number("time", -1e7, 1e7), ratio = item.Number("ratio", 0.01, 100);
    if (!time || !ratio) item.Fail("needs a time in seconds and a ratio");
    if (!timeline.volume.empty() && !(*time > timeline.volume.back().time_s))
      item.Fail("time", "does not rise");
    timeline.volume.push_back({*time, *ratio});
  });
}

void TakeConstraints(Fields& fields, Timeline& timeline) {
  timeline.table_height = fields.Number("table", -1e12, 1e12);
  TakeVolume(fields, timeline);
  fields.List("regions", "region", [&](Fields& item) { TakeRegion(item, timeline); });
  fields.List("pins", "pin", [&](Fields& item) {
    TimelinePin pin{TakeRegionName(item), item.Number("from", -1e7, 1e7),
                    item.Number("to", -1e7, 1e7)};
    if (pin.from_s && pin.to_s && !(*pin.to_s > *pin.from_s))
      item.Fail("to", "must be later than from");
    timeline.pins.push_back(pin);
  });
  fields.List("trajectories", "trajectory", [&](Fields& item) {
    TimelineTrajectory path{TakeRegionName(item), {}};
    item.List("points", "point", [&](Fields& point) {
      const auto time = point.Number("time", -1e7, 1e7);
      const auto at = point.Point("at");
      if (!time || !at)
        point.Fail("needs a time in seconds and a place, as in {\"time\": 0.5, \"at\": [0, 0, 1]}");
      if (!path.points.empty() && !(*time > path.points.back().time_s))
        point.Fail("time", "does not rise");
      path.points.push_back({*time, *at});
    });
    if (path.points.empty()) item.Fail("has no points");
    timeline.trajectories.push_back(path);
  });
}

std::string KeyName(const std::string& source, std::size_t index, const std::string& pose) {
  return fmt::format("{}: key {}{}", source, index, pose.empty() ? "" : " ('" + pose + "')");
}

void CheckTimes(const Timeline& timeline, const std::string& source) {
  // 0.1 + 0.2 is more than 0.3 in binary; a hold that is written so ends at the next key.
  constexpr double kLastDigit_s = 1e-6;
  for (std::size_t k = 0; k < timeline.keys.size(); ++k) {
    const TimelineKey& key = timeline.keys[k];
    const auto fail = [&](const std::string& field, const std::string& message) {
      throw TimelineError(
          fmt::format("{}: field '{}' {}", KeyName(source, k, key.pose), field, message),
          static_cast<int>(k));
    };
    if (key.time_s.has_value() != timeline.has_times())
      fail("time", "is missing, or others have none: all keys have a time, or none");
    if (k == 0 || !key.time_s) continue;
    const TimelineKey& before = timeline.keys[k - 1];
    if (!(*key.time_s > *before.time_s))
      fail("time", fmt::format("is {:g} s, which does not come after the key before it, at {:g} s",
                               *key.time_s, *before.time_s));
    if (*before.time_s + before.hold_s > *key.time_s + kLastDigit_s)
      throw TimelineError(
          fmt::format("{}: field 'hold' is {:g} s, but the next key comes {:g} s later",
                      KeyName(source, k - 1, before.pose), before.hold_s,
                      *key.time_s - *before.time_s),
          static_cast<int>(k - 1));
  }
}

void CheckRegionNames(const Timeline& timeline, const std::string& source) {
  std::vector<std::string> names;
  for (const TimelineRegion& region : timeline.regions) names.push_back(region.name);
  const auto check = [&](const std::string& name, const std::string& where, int key) {
    if (timeline.FindRegion(name)) return;
    const std::string nearest = NearestWord(name, names);
    throw TimelineError(
        fmt::format("{} names the region '{}', which is not among `regions`{}", where, name,
                    nearest.empty() ? "" : "; did you mean '" + nearest + "'?"),
        key);
  };
  for (const TimelinePin& pin : timeline.pins) check(pin.region, source + ": a pin", -1);
  for (const TimelineTrajectory& path : timeline.trajectories)
    check(path.region, source + ": a trajectory", -1);
  for (std::size_t k = 0; k < timeline.keys.size(); ++k)
    for (const auto& [region, turns] : timeline.keys[k].turns)
      check(region, KeyName(source, k, timeline.keys[k].pose) + ": field 'turns'",
            static_cast<int>(k));
}

void TakeKeys(Fields& fields, const std::string& source, const SpanDefaults& defaults,
              bool extended, Timeline& timeline) {
  const json* keys = fields.Take("keys");
  if (!keys || !keys->is_array())
    fields.Fail("has no list `keys`, as in \"keys\": [{\"pose\": \"rest\", \"time\": 0}, ...]");
  for (std::size_t k = 0; k < keys->size(); ++k) {
    const json& entry = (*keys)[k];
    std::string pose;
    if (entry.is_object() && entry.contains("pose") && entry["pose"].is_string())
      pose = entry["pose"];
    Fields key(entry, KeyName(source, k, pose), static_cast<int>(k));
    timeline.keys.push_back(TakeKey(key, defaults, extended));
    key.Done();
  }
  if (timeline.keys.size() < 2) fields.Fail("needs two keys or more");
}

/// The frame at which a time is shown, counted from the first key; as interpolate rounds.
double FrameOf(const Timeline& timeline, double time_s) {
  return std::round((time_s - *timeline.keys.front().time_s) * timeline.fps);
}

void CheckFrames(const Timeline& timeline, const std::string& source) {
  for (std::size_t k = 1; k < timeline.keys.size(); ++k) {
    const TimelineKey &before = timeline.keys[k - 1], &key = timeline.keys[k];
    if (FrameOf(timeline, *key.time_s) > FrameOf(timeline, *before.time_s)) continue;
    throw TimelineError(
        fmt::format("{} is in the same frame as the key before it: {:g} s and {:g} s at {:g} "
                    "frames a second; move it by a frame or more",
                    KeyName(source, k, key.pose), *before.time_s, *key.time_s, timeline.fps),
        static_cast<int>(k));
  }
}

/// Whether a key begins or stands at this time.
bool HasKeyAt(const Timeline& timeline, double time_s) {
  const double frame = FrameOf(timeline, time_s);
  return std::any_of(timeline.keys.begin(), timeline.keys.end(), [&](const TimelineKey& key) {
    const double begin = FrameOf(timeline, *key.time_s);
    return frame >= begin && frame <= begin + std::round(key.hold_s * timeline.fps);
  });
}

void CheckPins(const Timeline& timeline, const std::string& source) {
  for (const TimelinePin& pin : timeline.pins)
    for (const std::optional<double>& time : {pin.from_s, pin.to_s})
      if (time && !HasKeyAt(timeline, *time))
        throw TimelineError(
            fmt::format(
                "{}: the pin of '{}' begins or ends at {:g} s, where no key is; a pin holds "
                "from key to key, else its region would jump",
                source, pin.region, *time),
            -1);
}

}  // namespace

std::optional<Ease> EaseNamed(const std::string& name) {
  static const std::map<std::string, Ease> kNamed = {{"linear", {}},
                                                     {"ease", {0.25, 0.1, 0.25, 1}},
                                                     {"in", {0.42, 0, 1, 1}},
                                                     {"out", {0, 0, 0.58, 1}},
                                                     {"in-out", {0.42, 0, 0.58, 1}}};
  const auto at = kNamed.find(name);
  return at == kNamed.end() ? std::nullopt : std::optional<Ease>(at->second);
}

Timeline ParseTimeline(const std::string& text, const std::string& source) {
  const json root =
      IsShallowJson(text) ? json::parse(text, nullptr, false) : json(json::value_t::discarded);
  if (root.is_discarded() || !root.is_object())
    throw TimelineError(source +
                            ": not a timeline; write {\"schema\": 2, \"fps\": 24, \"keys\": "
                            "[{\"pose\": \"rest\", \"time\": 0}, ...]}",
                        -1);
  Fields fields(root, source, -1);
  const int schema = fields.Whole("schema", 1, 1e9).value_or(2);
  if (schema > 2)
    fields.Fail("schema",
                fmt::format("is {}, but this version reads 1 and 2; update Keypose", schema));
  const bool extended = schema == 2;
  Timeline timeline;
  timeline.fps = fields.Number("fps", 1e-3, 1000).value_or(0);
  if (timeline.fps == 0) fields.Fail("fps", "is missing: frames per second, as in 24");
  SpanDefaults defaults;
  if (extended) {
    timeline.loop = fields.Bool("loop").value_or(false);
    timeline.overshoot = fields.Bool("overshoot").value_or(false);
    defaults.travel = TakeTravel(fields).value_or(defaults.travel);
    defaults.ease = TakeEase(fields).value_or(defaults.ease);
    defaults.step = fields.Whole("step", 1, 1000).value_or(1);
    TakeConstraints(fields, timeline);
  }
  TakeKeys(fields, source, defaults, extended, timeline);
  fields.Done();
  CheckTimes(timeline, source);
  CheckRegionNames(timeline, source);
  return timeline;
}

void RequirePlayable(const Timeline& timeline, const std::string& source) {
  const std::string &first = timeline.keys.front().pose, &last = timeline.keys.back().pose;
  if (timeline.loop && first != last)
    throw TimelineError(
        fmt::format("{}: the timeline loops, but it begins with pose '{}' and ends with '{}'; end "
                    "it with '{}' again, at the time when the loop closes",
                    source, first, last, first),
        static_cast<int>(timeline.keys.size()) - 1);
  if (!timeline.has_times()) return;
  CheckFrames(timeline, source);
  CheckPins(timeline, source);
}

}  // namespace keypose
