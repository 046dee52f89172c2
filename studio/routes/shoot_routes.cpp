#include "studio/routes/shoot_routes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/io/pictures/photograph_files.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/text/text.h"
#include "studio/http/session_answers.h"
#include "studio/project/pose_photographs.h"
#include "studio/routes/serial_ports.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr int kMostRings = 12, kMostAngles = 360, kMostFlips = 3;
constexpr const char* kCommands[] = {"shoot", "again", "skip",      "pause", "go-on",
                                     "done",  "at",    "next-pose", "live",  "end"};

double NumberWithin(const json& value, double least, double most, const char* what) {
  const double number = value;
  if (!(number >= least && number <= most))
    throw UsageError(fmt::format("{} is {}; it can be {} to {}", what, number, least, most));
  return number;
}

int WholeWithin(const json& value, int least, int most, const char* what) {
  const double number = NumberWithin(value, least, most, what);
  if (number != std::floor(number)) throw UsageError(fmt::format("{} is no whole number", what));
  return static_cast<int>(number);
}

/// "simulated", or one of the kinds with a place behind a colon: "grbl:/dev/ttyUSB0".
void RequireDevice(const std::string& text, const std::vector<std::string>& plain,
                   const std::vector<std::string>& with_place, const char* what) {
  if (std::find(plain.begin(), plain.end(), text) != plain.end()) return;
  const auto colon = text.find(':');
  const std::string kind = text.substr(0, colon);
  const bool known = std::find(with_place.begin(), with_place.end(), kind) != with_place.end();
  if (!known || colon == std::string::npos || colon + 1 == text.size())
    throw UsageError(fmt::format("'{}' is no {}; choose one, and say where it is", text, what));
}

/// Flags of `shoot` that few need. @throws UsageError  one that there is not, or out of range
std::vector<std::pair<std::string, std::string>> MoreFlags(const json& more) {
  std::vector<std::pair<std::string, std::string>> flags;
  for (const auto& [name, value] : more.items()) {
    const std::string text = value;
    if (name == "axis") {
      if (text != "X" && text != "Y" && text != "Z")
        throw UsageError(fmt::format("a table's axis is X, Y or Z, not '{}'", text));
    } else if (name == "settle" || name == "focus-stack" || name == "degrees-per-unit" ||
               name == "speed") {
      char* end = nullptr;
      const double number = std::strtod(text.c_str(), &end);
      const double least = name == "settle" ? 0 : 1e-6;
      if (text.empty() || *end != '\0' || !(number >= least && number <= 1e4))
        throw UsageError(fmt::format("'{}' is no number for {}", text, name));
    } else if (name != "white-balance") {
      throw UsageError(fmt::format("shooting has no setting '{}'", name));
    }
    flags.emplace_back(name, text);
  }
  return flags;
}

ShootSetup SetupFrom(const json& body) {
  ShootSetup setup;
  setup.pose = body.at("pose");
  setup.camera = body.at("camera");
  setup.turntable = body.at("turntable");
  if (!pipeline::IsName(setup.pose))
    throw UsageError(
        fmt::format("a pose's name may have {}; '{}' has not", pipeline::kNameRule, setup.pose));
  RequireDevice(setup.camera, {"gphoto2", "simulated"}, {"folder", "simulated"}, "camera");
  RequireDevice(setup.turntable, {"none", "simulated"}, {"grbl", "steps"}, "turntable");
  for (const json& ring : body.at("rings"))
    setup.rings_deg.push_back(NumberWithin(ring, -90, 90, "a ring's height"));
  if (setup.rings_deg.empty() || setup.rings_deg.size() > kMostRings)
    throw UsageError(fmt::format("give 1 to {} rings", kMostRings));
  setup.angles = WholeWithin(body.at("angles"), 3, kMostAngles, "the number of angles");
  setup.flips = WholeWithin(body.at("flips"), 0, kMostFlips, "the number of flips");
  setup.more = MoreFlags(body.value("more", json::object()));
  return setup;
}

json SetupJson(const ShootSetup& setup) {
  json all = {{"pose", setup.pose},       {"camera", setup.camera}, {"turntable", setup.turntable},
              {"rings", setup.rings_deg}, {"angles", setup.angles}, {"flips", setup.flips}};
  for (const auto& [name, text] : setup.more) all["more"][name] = text;
  return all;
}

/// The plans with which poses were begun, by the pose's name: a session goes on with the same one.
json PlansOf(const fs::path& photos) {
  json plans = json::object();
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(photos, error)) {
    const fs::path file = entry.path() / "shoot.json";
    if (!fs::is_regular_file(file, error) || pipeline::RealDisk().LeadsOutside(file, photos))
      continue;
    const std::string text = ReadFile(file);
    const json side = IsShallowJson(text) ? json::parse(text, nullptr, false) : json();
    if (side.is_object() && side.value("plan", json()).is_object())
      plans[WithoutOddBytes(entry.path().filename().string())] = side["plan"];
  }
  return plans;
}

}  // namespace

ShootRoutes::ShootRoutes(SharedProject& project)
    : PageRoutes(project), shoot_(project.folder(), ToPages(project.hub(), "shoot")) {}

void ShootRoutes::AddTo(RouteTable& table) {
  AddSession(table);
  AddPictures(table);
}

void ShootRoutes::AddSession(RouteTable& table) {
  const fs::path last = project_.folder() / ".keypose/studio/shoot.json";
  table.Get("/api/shoot", [this, last](const Question&) {
    json answer = StoryJson(shoot_.State());
    answer["ports"] = SerialPorts();
    answer["plans"] = PlansOf(project_.folder() / "photos");
    answer["setup"] = SavedJson(last);
    return JsonAnswer(answer);
  });
  table.Post(
      "/api/shoot/start",
      [this, last](const Question& question) {
        const ShootSetup setup = SetupFrom(question.Json());
        shoot_.Start(setup);
        WriteFileAtomically(last, SetupJson(setup).dump());
        return JsonAnswer({{"started", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/shoot/command",
      [this](const Question& question) {
        const json body = question.Json();
        const std::string command = body.at("command");
        if (std::find(std::begin(kCommands), std::end(kCommands), command) == std::end(kCommands))
          throw UsageError(fmt::format("there is no command '{}'", command));
        shoot_.Say(body.dump());
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/shoot/interrupt",
      [this](const Question&) {
        shoot_.Interrupt();
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
}

void ShootRoutes::AddPictures(RouteTable& table) {
  table.Get("/api/shoot/live", [this](const Question&) {
    if (!fs::is_regular_file(shoot_.LiveFile())) throw NotFound("there is no live view");
    // In one piece: the file is replaced several times a second.
    return Answer{200, "image/jpeg", ReadFile(shoot_.LiveFile()), {}, {}};
  });
  table.Get("/api/shoot/picture", [this](const Question& question) {
    const std::string path = question.Need("path");
    const int width = WholeNumber(question.Get("width", "0"), 0, 100000);
    const fs::path file = project_.folder() / path;
    if (!StaysBelow(path) || !path.starts_with("photos/") || !IsPhotographName(file) ||
        !fs::is_regular_file(file) || pipeline::RealDisk().LeadsOutside(file, project_.folder()))
      throw NotFound(fmt::format("there is no photograph {}", path));
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, width));
  });
}

}  // namespace keypose::studio
