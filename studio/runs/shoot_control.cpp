#include "studio/runs/shoot_control.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "pipeline/run/opened_project.h"
#include "studio/runs/shoot_events.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr char kLive[] = R"({"command": "live", "on": true})";
constexpr char kEnd[] = R"({"command": "end"})";

std::string EventOf(const std::string& line) {
  const json value = json::parse(line, nullptr, false);
  if (!value.is_object() || !value.contains("event") || !value["event"].is_string()) return "";
  return value["event"];
}

std::vector<std::string> WordsFor(const ShootSetup& setup, const fs::path& project,
                                  const fs::path& live) {
  // In one word with its flag, no value can be taken for another flag.
  std::vector<std::string> words = {(pipeline::ProgramFolder() / "keypose-shoot").string(),
                                    "-C",
                                    project.string(),
                                    "--pose=" + setup.pose,
                                    "--camera=" + setup.camera,
                                    "--turntable=" + setup.turntable,
                                    fmt::format("--rings={}", fmt::join(setup.rings_deg, ",")),
                                    fmt::format("--angles={}", setup.angles),
                                    fmt::format("--flips={}", setup.flips),
                                    "--commands",
                                    "--live=" + live.string()};
  for (const auto& [flag, value] : setup.more) words.push_back("--" + flag + "=" + value);
  return words;
}

}  // namespace

ShootControl::ShootControl(fs::path project, SessionListener listener)
    : project_(std::move(project)),
      relay_({[](const std::string& line) { return !EventOf(line).empty(); }, KeepShootEvent, kEnd},
             std::move(listener)) {}

fs::path ShootControl::File(const char* name) const { return project_ / ".keypose/studio" / name; }

void ShootControl::Start(const ShootSetup& setup) {
  const auto without_old_picture = [&] {
    std::error_code ignored;
    fs::remove(LiveFile(), ignored);
  };
  relay_.Start(WordsFor(setup, project_, LiveFile()), project_, File("shoot.txt"),
               without_old_picture, kLive);
}

}  // namespace keypose::studio
