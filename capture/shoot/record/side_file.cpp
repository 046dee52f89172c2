#include "capture/shoot/record/side_file.h"

#include <cmath>
#include <ctime>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::capture::shoot {

using nlohmann::json;

namespace {

std::int64_t SecondsOf(const std::string& text) {
  std::tm parts = {};
  const char* end = strptime(text.c_str(), "%Y-%m-%dT%H:%M:%SZ", &parts);
  if (!end || *end) throw InputError("the time '" + text + "' has another form");
  return timegm(&parts);
}

json SettingsJson(const ExposureSettings& settings) {
  json out = json::object();
  const auto put = [&](const char* key, double value) {
    if (value > 0) out[key] = Decimal(value, 6);
  };
  put("exposure_s", settings.exposure_s);
  put("aperture", settings.aperture);
  put("iso", settings.iso);
  put("focal_mm", settings.focal_mm);
  put("focal_35mm", settings.focal_35mm);
  return out;
}

ExposureSettings SettingsFrom(const json& entry) {
  ExposureSettings settings;
  settings.exposure_s = entry.value("exposure_s", 0.0);
  settings.aperture = entry.value("aperture", 0.0);
  settings.iso = entry.value("iso", 0.0);
  settings.focal_mm = entry.value("focal_mm", 0.0);
  settings.focal_35mm = entry.value("focal_35mm", 0.0);
  return settings;
}

std::vector<Finding> FindingsFrom(const json& list) {
  std::vector<Finding> findings;
  for (const json& entry : list)
    findings.push_back({entry.at("code"), entry.at("words"), entry.at("do")});
  return findings;
}

std::string FileName(const json& entry, const char* key) {
  const std::string name = entry.value(key, "");
  if (!name.empty() && !IsOneName(name))
    throw InputError("'" + name + "' is not the name of a file of the folder");
  return name;
}

PhotographEntry EntryFrom(const json& in, const Shot& shot) {
  PhotographEntry entry;
  entry.shot = shot;
  entry.file = FileName(in, "file");
  entry.raw = FileName(in, "raw");
  entry.time = SecondsOf(in.at("time"));
  entry.readable = in.value("readable", true);
  entry.width = in.value("width", 0);
  entry.height = in.value("height", 0);
  entry.settings = SettingsFrom(in.value("settings", json::object()));
  entry.crispness = in.value("crispness", 0.0);
  entry.sharpness = in.value("sharpness", 0.0);
  entry.exposure = in.value("exposure", 0.0);
  entry.light = in.value("light", 0.0);
  entry.clipped = in.value("clipped", 0.0);
  entry.mask_fraction = in.value("mask_fraction", 0.0);
  entry.touches_border = in.value("touches_border", false);
  entry.findings = FindingsFrom(in.at("findings"));
  return entry;
}

ShotPlan PlanFrom(const json& in) {
  ShotPlan plan;
  plan.rings_deg = in.at("rings_deg").get<std::vector<double>>();
  plan.angles = in.at("angles");
  plan.flips = in.value("flips", 0);
  plan.focus_stack = in.value("focus_stack", 1);
  if (const auto problems = plan.Problems(); !problems.empty()) throw InputError(problems.front());
  return plan;
}

Shot ShotFrom(const ShotPlan& plan, const std::string& name) {
  const auto shot = ShotNamed(plan, name);
  if (!shot) throw InputError("'" + name + "' is no photograph of its plan");
  return *shot;
}

CarriedWhite WhiteFrom(const json& in) {
  CarriedWhite white{in.at("gains").get<std::array<double, 3>>(), in.value("from", "")};
  for (const double gain : white.gains)
    if (!(gain > 0.01 && gain < 100)) throw InputError("a white balance gain is out of range");
  return white;
}

SideFile SideFrom(const json& root) {
  SideFile side;
  if (root.at("schema") != 1) throw InputError("it is of a newer version of keypose");
  side.pose = root.at("pose");
  side.plan = PlanFrom(root.at("plan"));
  side.camera = root.value("camera", "");
  side.turntable = root.value("turntable", "");
  if (root.contains("white_balance")) side.white = WhiteFrom(root.at("white_balance"));
  for (const auto& [name, entry] : root.at("photographs").items()) {
    const Shot shot = ShotFrom(side.plan, name);
    side.photographs[shot] = EntryFrom(entry, shot);
  }
  for (const json& in : root.at("rings")) {
    RingEntry ring;
    ring.ring = in.at("ring");
    ring.flip = in.at("flip");
    if (in.contains("moved_px")) ring.moved_px = in.at("moved_px").get<double>();
    ring.missing_deg = in.at("missing_deg").get<std::vector<double>>();
    ring.findings = FindingsFrom(in.at("findings"));
    side.rings.push_back(std::move(ring));
  }
  for (const json& name : root.at("skipped")) side.skipped.insert(ShotFrom(side.plan, name));
  return side;
}

}  // namespace

double Decimal(double value, int digits) {
  const double power = std::pow(10.0, digits);
  return std::round(value * power) / power;
}

std::string TimeText(std::int64_t seconds) {
  const std::time_t time = seconds;
  std::tm parts = {};
  gmtime_r(&time, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

const RingEntry* SideFile::FindRing(int flip, int ring) const {
  for (const RingEntry& entry : rings)
    if (entry.flip == flip && entry.ring == ring) return &entry;
  return nullptr;
}

json FindingsJson(const std::vector<Finding>& findings) {
  json list = json::array();
  for (const Finding& finding : findings)
    list.push_back({{"code", finding.code}, {"words", finding.words}, {"do", finding.what_to_do}});
  return list;
}

json PlanJson(const ShotPlan& plan) {
  return {{"rings_deg", plan.rings_deg},
          {"angles", plan.angles},
          {"flips", plan.flips},
          {"focus_stack", plan.focus_stack}};
}

json EntryJson(const ShotPlan& plan, const PhotographEntry& entry) {
  json out = {{"file", entry.file},
              {"ring", entry.shot.ring},
              {"angle_deg", AngleOf(plan, entry.shot)},
              {"tilt_deg", TiltOf(plan, entry.shot)},
              {"flip", entry.shot.flip},
              {"time", TimeText(entry.time)},
              {"width", entry.width},
              {"height", entry.height},
              {"settings", SettingsJson(entry.settings)},
              {"crispness", Decimal(entry.crispness, 4)},
              {"sharpness", Decimal(entry.sharpness, 2)},
              {"exposure", Decimal(entry.exposure, 2)},
              {"light", Decimal(entry.light, 6)},
              {"clipped", Decimal(entry.clipped, 5)},
              {"mask_fraction", Decimal(entry.mask_fraction, 5)},
              {"findings", FindingsJson(entry.findings)}};
  if (!entry.raw.empty()) out["raw"] = entry.raw;
  if (!entry.readable) out["readable"] = false;
  if (entry.touches_border) out["touches_border"] = true;
  return out;
}

json RingJson(const RingEntry& ring) {
  json out = {{"ring", ring.ring},
              {"flip", ring.flip},
              {"missing_deg", ring.missing_deg},
              {"findings", FindingsJson(ring.findings)}};
  if (ring.moved_px) out["moved_px"] = Decimal(*ring.moved_px, 2);
  return out;
}

std::string SideFileText(const SideFile& side) {
  json root = {{"schema", 1},
               {"pose", side.pose},
               {"plan", PlanJson(side.plan)},
               {"camera", side.camera},
               {"turntable", side.turntable},
               {"photographs", json::object()},
               {"rings", json::array()},
               {"skipped", json::array()}};
  if (side.white)
    root["white_balance"] = {{"gains", side.white->gains}, {"from", side.white->from}};
  for (const auto& [shot, entry] : side.photographs)
    root["photographs"][NameOf(side.plan, shot)] = EntryJson(side.plan, entry);
  for (const RingEntry& ring : side.rings) root["rings"].push_back(RingJson(ring));
  for (const Shot& shot : side.skipped) root["skipped"].push_back(NameOf(side.plan, shot));
  return root.dump(1) + "\n";
}

SideFile ParseSideFile(const std::string& text, const std::string& where) {
  const char* const advice =
      "; remove it and start again: what it says of the photographs is measured anew";
  RequireShallowJson(text, where);
  try {
    return SideFrom(json::parse(text));
  } catch (const InputError& error) {
    throw InputError(where + " is damaged: " + error.what() + advice);
  } catch (const json::exception& error) {
    throw InputError(where + " is damaged (" + JsonFault(error) + ")" + advice);
  }
}

}  // namespace keypose::capture::shoot
