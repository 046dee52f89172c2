#include "studio/routes/armature_setup.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/text/text.h"
#include "studio/http/session_answers.h"
#include "studio/project/pose_photographs.h"
#include "studio/routes/take_puppet.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

/// A file that the form names, and whether there can be a session without it.
struct SetupFile {
  const char* name;
  std::string ArmatureSetup::*value;
  bool needed = false, may_be_folder = false;
};
constexpr std::array<SetupFile, 9> kSetupFiles = {{
    {"description", &ArmatureSetup::description, true},
    {"chains", &ArmatureSetup::chains, true},
    {"skeleton", &ArmatureSetup::skeleton},
    {"mesh", &ArmatureSetup::mesh},
    {"weights", &ArmatureSetup::weights},
    {"texture", &ArmatureSetup::texture},
    {"plate", &ArmatureSetup::plate, false, true},
    {"shot", &ArmatureSetup::shot},
    {"set", &ArmatureSetup::set},
}};

std::string UpFrom(const json& body, const char* name) {
  const std::string up = body.value(name, std::string("z"));
  if (up != "y" && up != "z") throw UsageError(fmt::format("{} is y or z, not '{}'", name, up));
  return up;
}

std::string PortFrom(const json& body, const std::string& calibration) {
  const std::string port = body.at("port");
  const bool device = port.starts_with("/dev/") && port.find("..") == std::string::npos;
  if (port != "simulated" && !device)
    throw UsageError(
        fmt::format("'{}' is no serial port; one is called such as /dev/ttyACM0, or "
                    "choose a simulated puppet",
                    port));
  if (device && !StaysBelow(calibration))
    throw UsageError(
        "name the file of the puppet's calibration, such as armature/puppet.json; Calibrate makes "
        "it");
  return port;
}

}  // namespace

std::string TakeName(const json& name) {
  const std::string take = name;
  if (!pipeline::IsName(take) || take == "example")
    throw UsageError(
        fmt::format("a take's name may have {}; '{}' cannot be one", pipeline::kNameRule, take));
  return take;
}

fs::path FileOfProject(const fs::path& project, const std::string& name, bool may_be_folder) {
  const fs::path file = project / name;
  std::error_code error;
  const bool there =
      StaysBelow(name) && !pipeline::RealDisk().LeadsOutside(file, project) &&
      (fs::is_regular_file(file, error) || (may_be_folder && fs::is_directory(file, error)));
  if (!there)
    throw NotFound(
        fmt::format("there is no {} in the project; put the puppet's files into its "
                    "folder 'armature'",
                    name));
  return file;
}

double WithinRange(const json& value, double least, double most, const char* what) {
  const double number = value;
  if (!(number >= least && number <= most))
    throw UsageError(fmt::format("{} is {}; it can be {} to {}", what, number, least, most));
  return number;
}

ArmatureSetup ArmatureSetupFrom(const json& body, const fs::path& project) {
  ArmatureSetup setup;
  setup.take = TakeName(body.at("take"));
  for (const SetupFile& file : kSetupFiles) {
    const std::string name = body.value(file.name, std::string());
    if (name.empty() && file.needed)
      throw UsageError(fmt::format("which file is the {}?", file.name));
    if (!name.empty()) FileOfProject(project, name, file.may_be_folder);
    setup.*file.value = name;
  }
  setup.armature_up = UpFrom(body, "armature_up");
  setup.skeleton_up = UpFrom(body, "skeleton_up");
  setup.calibration = body.value("calibration", std::string());
  setup.port = PortFrom(body, setup.calibration);
  if (setup.port == "simulated") setup.calibration.clear();
  if (!setup.calibration.empty() &&
      pipeline::RealDisk().LeadsOutside(project / setup.calibration, project))
    throw UsageError(fmt::format("{} leads out of the project", setup.calibration));
  setup.fps = WithinRange(body.at("fps"), 1, 1000, "the number of frames a second");
  setup.step = static_cast<int>(WithinRange(body.at("step"), 1, 100, "frames for each recorded"));
  const fs::path take = project / "armature" / setup.take;
  if (pipeline::RealDisk().LeadsOutside(take, project))
    throw UsageError(fmt::format("the take {} leads out of the project", setup.take));
  return setup;
}

CalibrateSetup CalibrateSetupFrom(const json& body, const fs::path& project) {
  CalibrateSetup setup;
  setup.what = body.at("what");
  setup.description = body.at("description");
  if (setup.description.empty()) throw UsageError("which file is the description?");
  FileOfProject(project, setup.description, false);
  setup.calibration = body.value("calibration", std::string());
  setup.port = PortFrom(body, setup.calibration);
  setup.known = body.value("known", std::string());
  setup.written = body.value("written", std::string());
  if (setup.what == "gears" && setup.known.empty())
    throw UsageError("which file has the known angles? Lines such as `leftKneeBend 30 60 90`");
  if (!setup.known.empty()) FileOfProject(project, setup.known, false);
  for (const std::string* file : {&setup.calibration, &setup.written})
    if (!file->empty() &&
        (!StaysBelow(*file) || pipeline::RealDisk().LeadsOutside(project / *file, project)))
      throw UsageError(fmt::format("{} leads out of the project", *file));
  return setup;
}

json ArmatureSetupJson(const ArmatureSetup& setup) {
  json all = {{"take", setup.take},
              {"port", setup.port},
              {"calibration", setup.calibration},
              {"armature_up", setup.armature_up},
              {"skeleton_up", setup.skeleton_up},
              {"fps", setup.fps},
              {"step", setup.step}};
  for (const SetupFile& file : kSetupFiles) all[file.name] = setup.*file.value;
  return all;
}

fs::path LastSetupFile(const fs::path& project) {
  return project / ".keypose/studio/armature.json";
}

namespace {
fs::path SetupFileOf(const fs::path& project, const std::string& take) {
  return project / ".keypose/studio/takes" / (take + ".json");
}
}  // namespace

void RequireTake(const fs::path& project, const std::string& take) {
  const fs::path curves = project / "armature" / TakeName(take) / "curves.json";
  if (pipeline::RealDisk().LeadsOutside(curves, project) || !fs::is_regular_file(curves))
    throw NotFound(fmt::format("there is no take {} with recorded curves", take));
}

json SetupJsonOfTake(const fs::path& project, const std::string& take) {
  RequireTake(project, take);
  json saved = SavedJson(SetupFileOf(project, take));
  if (!saved.is_object()) saved = PuppetOfTake(project, take, SavedJson(LastSetupFile(project)));
  saved["take"] = take;
  return saved;
}

ArmatureSetup SetupOfTake(const fs::path& project, const std::string& take) {
  const ArmatureSetup setup = ArmatureSetupFrom(SetupJsonOfTake(project, take), project);
  if (!fs::exists(SetupFileOf(project, take))) KeepSetupOfTake(project, setup);
  return setup;
}

void KeepSetupOfTake(const fs::path& project, const ArmatureSetup& setup) {
  const fs::path file = SetupFileOf(project, setup.take);
  fs::create_directories(file.parent_path());
  WriteFileAtomically(file, ArmatureSetupJson(setup).dump());
}

}  // namespace keypose::studio
