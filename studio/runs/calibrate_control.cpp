#include "studio/runs/calibrate_control.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/values/errors.h"
#include "studio/runs/armature_control.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A loose plug tells of itself many times a second.
constexpr std::size_t kMostKept = 400;

bool IsCalibrateEvent(const std::string& line) {
  const json told = json::parse(line, nullptr, false);
  return told.is_object() && told.contains("event") && told["event"].is_string();
}

void KeepCalibrateEvent(const std::string& event, std::vector<std::string>* events) {
  if (events->size() >= kMostKept) events->erase(events->begin());
  events->push_back(event);
}

std::vector<std::string> CalibrateWords(const CalibrateSetup& setup) {
  std::vector<std::string> words = {ArmatureProgram().string(), "calibrate", "--page"};
  if (setup.what == "verify" || setup.what == "wiggle")
    words.push_back("--" + setup.what);
  else if (setup.what == "gears")
    words.push_back("--known=" + setup.known);
  else if (setup.what != "zero")
    throw UsageError(fmt::format("there is no calibration '{}'", setup.what));
  if (setup.what == "gears" && !setup.written.empty())
    words.push_back("--written=" + setup.written);
  words.push_back("--description=" + setup.description);
  words.push_back("--port=" + setup.port);
  if (!setup.calibration.empty()) words.push_back("--calibration=" + setup.calibration);
  return words;
}

}  // namespace

CalibrateControl::CalibrateControl(fs::path project)
    : project_(std::move(project)),
      relay_({IsCalibrateEvent, KeepCalibrateEvent, ""},
             {[](std::uint64_t, const std::string&) {},
              [](std::uint64_t, int, const std::string&) {}}) {}

CalibrateControl::~CalibrateControl() { relay_.Interrupt(); }

void CalibrateControl::Start(const CalibrateSetup& setup) {
  const fs::path notes = project_ / ".keypose/studio";
  relay_.Start(
      CalibrateWords(setup), project_, notes / "calibrate.txt",
      [&] { fs::create_directories(notes); }, "");
}

}  // namespace keypose::studio
