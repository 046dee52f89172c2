// The puppet as an input device: a session of `keypose armature live`, what its page shows, frames
// baked from what was recorded.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/errors.h"
#include "core/file_names.h"
#include "core/io/files.h"
#include "core/io/mesh_io.h"
#include "pipeline/real_disk.h"
#include "pipeline/session.h"
#include "pipeline/text.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/photographs.h"
#include "studio/server/routes.h"
#include "studio/server/serial_ports.h"
#include "studio/server/session_answers.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostListed = 500;
constexpr int kMostDepth = 4;

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

/// @throws UsageError  it lies outside of the project @throws NotFound  it is not there
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

std::string TakeFrom(const json& body) {
  const std::string take = body.at("take");
  if (!pipeline::IsName(take) || take == "example")
    throw UsageError(
        fmt::format("a take's name may have {}; '{}' cannot be one", pipeline::kNameRule, take));
  return take;
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
        "name the file of the puppet's calibration, such as armature/puppet.json; "
        "`keypose armature calibrate` makes it");
  return port;
}

ArmatureSetup ArmatureSetupFrom(const json& body, const fs::path& project) {
  ArmatureSetup setup;
  setup.take = TakeFrom(body);
  for (const SetupFile& file : kSetupFiles) {
    const std::string name = body.value(file.name, std::string());
    if (name.empty() && file.needed)
      throw UsageError(fmt::format("which file is the {}?", file.name));
    if (!name.empty()) FileOfProject(project, name, file.may_be_folder);
    setup.*file.value = name;
  }
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

json ArmatureSetupJson(const ArmatureSetup& setup) {
  json all = {{"take", setup.take},
              {"port", setup.port},
              {"calibration", setup.calibration},
              {"fps", setup.fps},
              {"step", setup.step}};
  for (const SetupFile& file : kSetupFiles) all[file.name] = setup.*file.value;
  return all;
}

/// The setup of the theropod that `keypose armature example` makes.
json ExampleSetup() {
  const std::string folder = "armature/example/";
  return {{"take", "take1"},
          {"port", "simulated"},
          {"calibration", folder + "theropod.json"},
          {"fps", 24},
          {"step", 2},
          {"description", folder + "theropod.txt"},
          {"chains", folder + "theropod_chains.txt"},
          {"skeleton", folder + "theropod.bvh"},
          {"mesh", folder + "theropod.ply"},
          {"weights", ""},
          {"texture", ""},
          {"plate", folder + "plate.png"},
          {"shot", folder + "shot.json"},
          {"set", folder + "set.ply"}};
}

/// Files below the folder 'armature', from the project's folder, and the takes in it.
void ListArmature(const fs::path& project, json* files, json* takes) {
  std::error_code error;
  *files = json::array();
  *takes = json::array();
  fs::recursive_directory_iterator at(project / "armature", error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const fs::path& path = at->path();
    const std::string name = WithoutOddBytes(path.lexically_relative(project).string());
    if (at->is_directory(error)) {
      const bool take = fs::exists(path / "journal.jsonl", error);
      if (take && at.depth() == 0) takes->push_back(WithoutOddBytes(path.filename().string()));
      if (take || at.depth() >= kMostDepth) at.disable_recursion_pending();
    } else if (files->size() < kMostListed) {
      files->push_back(name);
    }
  }
  std::sort(files->begin(), files->end());
  std::sort(takes->begin(), takes->end());
}

int FrameFrom(const json& body) {
  return static_cast<int>(WithinRange(body.at("frame"), 0, 1e6, "a frame"));
}

/// What is typed into `armature live` for a command of the page.
std::string LineOf(const json& body) {
  const std::string command = body.at("command");
  for (const char* plain : {"record", "next", "back", "cut", "end"})
    if (command == plain) return command;
  if (command == "next-plate") return "plate next";
  if (command == "plate") return fmt::format("plate {}", FrameFrom(body));
  if (command == "goto") return fmt::format("goto {}", FrameFrom(body));
  if (command == "zero") {
    const std::string joint = body.at("joint");
    const bool one_word = std::none_of(joint.begin(), joint.end(), [](unsigned char c) {
      return std::isspace(c) || std::iscntrl(c);
    });
    if (joint.empty() || !one_word) throw UsageError("a joint's name is one word");
    return "zero " + joint;
  }
  throw UsageError(fmt::format("there is no command '{}'", command));
}

}  // namespace

void Routes::FollowArmature() {
  ArmatureControl::Listener listener;
  static_cast<SessionListener&>(listener) = ToPages(hub_, "armature");
  listener.baked = [this](int code, const std::string& message) {
    hub_.Send("armature_baked", json{{"exit_code", code}, {"message", message}}.dump());
  };
  armature_ = std::make_unique<ArmatureControl>(folder_, listener);
}

void Routes::AddArmature() {
  const fs::path last = folder_ / ".keypose/studio/armature.json";
  Add("GET", "/api/armature", [this, last](const Question&) {
    const ArmatureStory story = armature_->Story();
    json answer = StoryJson(story);
    answer["baking"] = story.baking;
    answer["ports"] = SerialPorts();
    answer["setup"] = SavedJson(last);
    ListArmature(folder_, &answer["files"], &answer["takes"]);
    return JsonAnswer(answer);
  });
  Add("POST", "/api/armature/example", [this](const Question&) {
    const fs::path example = folder_ / "armature/example";
    if (pipeline::RealDisk().LeadsOutside(example, folder_))
      throw UsageError("armature/example leads out of the project");
    if (!fs::exists(example / "set.ply")) {
      const ChildResult made = RunChild({(pipeline::ProgramFolder() / "keypose-armature").string(),
                                         "example", "--folder", example.string()},
                                        folder_, 60);
      if (made.exit_code != 0) throw DiskError(made.output);
    }
    return JsonAnswer(ExampleSetup());
  });
  Add("POST", "/api/armature/start", [this, last](const Question& question) {
    const ArmatureSetup setup = ArmatureSetupFrom(question.Json(), folder_);
    armature_->Start(setup);
    WriteFileAtomically(last, ArmatureSetupJson(setup).dump());
    return JsonAnswer({{"started", true}});
  });
  Add("POST", "/api/armature/command", [this](const Question& question) {
    armature_->Say(LineOf(question.Json()));
    return JsonAnswer({{"sent", true}});
  });
  Add("POST", "/api/armature/interrupt", [this](const Question&) {
    armature_->Interrupt();
    return JsonAnswer({{"sent", true}});
  });
  Add("POST", "/api/armature/bake", [this, last](const Question& question) {
    const std::string between = question.Json().at("between");
    if (between != "hold" && between != "linear" && between != "smooth" && between != "keys")
      throw UsageError("between frames it can hold, go linear or smooth; or make keys");
    const ArmatureSetup setup = ArmatureSetupFrom(SavedJson(last), folder_);
    FileOfProject(folder_, fmt::format("armature/{}/curves.json", setup.take), false);
    armature_->Bake(setup, between);
    return JsonAnswer({{"started", true}});
  });
  AddArmatureViews();
}

void Routes::AddArmatureViews() {
  const auto setup = [this] {
    return ArmatureSetupFrom(SavedJson(folder_ / ".keypose/studio/armature.json"), folder_);
  };
  const auto page_file = [this](const char* name) {
    const fs::path file = armature_->PageFolder() / name;
    if (!fs::is_regular_file(file)) throw NotFound("no session has begun");
    return ReadFile(file);
  };
  Add("GET", "/api/armature/pose", [this](const Question& question) {
    const int after = WholeNumber(question.Get("after", "0"), 0, 2147483647);
    const std::string pose = armature_->Pose(static_cast<std::uint64_t>(after));
    return Answer{200, "application/json", pose.empty() ? "null" : pose, {}, {}};
  });
  Add("GET", "/api/armature/view", [page_file](const Question&) {
    return Answer{200, "application/json", page_file("view.json"), {}, {}};
  });
  Add("GET", "/api/armature/weights",
      [page_file](const Question&) { return BytesAnswer(page_file("weights.bin")); });
  Add("GET", "/api/armature/frames", [page_file](const Question& question) {
    const std::string all = page_file("frames.bin");
    const auto from =
        static_cast<std::size_t>(WholeNumber(question.Get("from", "0"), 0, 2147483647));
    return BytesAnswer(from < all.size() ? all.substr(from) : "");
  });
  Add("GET", "/api/armature/mesh", [this, setup](const Question& question) {
    const ArmatureSetup now = setup();
    const bool set = question.Get("what") == "set";
    const std::string& name = set ? now.set : now.mesh;
    if (set && name.empty()) throw NotFound("the set has no geometry");
    return BytesAnswer(
        MeshBytes(ReadMesh(name.empty() ? armature_->PageFolder() / "rest.ply" : folder_ / name)));
  });
  Add("GET", "/api/armature/texture", [this, setup](const Question&) {
    const ArmatureSetup now = setup();
    if (now.texture.empty()) throw NotFound("the character has no texture");
    return PictureAnswer(PictureFile(PictureFolder(), folder_ / now.texture, 0));
  });
  Add("GET", "/api/armature/plate", [this, page_file](const Question& question) {
    const int index = WholeNumber(question.Get("index", "0"), 0, 1000000);
    const json pictures = json::parse(page_file("view.json")).at("pictures");
    if (pictures.empty()) throw NotFound("there is no plate");
    const fs::path file =
        pictures.at(std::min(static_cast<std::size_t>(index), pictures.size() - 1))
            .get<std::string>();
    if (pipeline::RealDisk().LeadsOutside(file, folder_))
      throw NotFound("the plate leads out of the project");
    return PictureAnswer(PictureFile(PictureFolder(), file, 0));
  });
}

}  // namespace keypose::studio
