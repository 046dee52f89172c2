#include "studio/routes/armature_routes.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/io/meshes/mesh_io.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "pipeline/disk/real_disk.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/text/text.h"
#include "studio/http/session_answers.h"
#include "studio/meshes/mesh_bytes.h"
#include "studio/project/pose_photographs.h"
#include "studio/routes/armature_setup.h"
#include "studio/routes/serial_ports.h"
#include "studio/runs/take_editor.h"

namespace keypose::studio {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr std::size_t kMostListed = 500;
constexpr int kMostDepth = 4;

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
          {"armature_up", "z"},
          {"skeleton_up", "z"},
          {"plate", folder + "plate.png"},
          {"shot", folder + "shot.json"},
          {"set", folder + "set.ply"}};
}

/// Files below the folder 'armature', from the project's folder; the takes that were recorded into
/// it, and those that were edited.
void ListArmature(const fs::path& project, json* answer) {
  std::error_code error;
  json files = json::array(), takes = json::array(), edited = json::array();
  fs::recursive_directory_iterator at(project / "armature", error);
  for (; !error && at != fs::recursive_directory_iterator(); at.increment(error)) {
    const fs::path& path = at->path();
    const std::string name = WithoutOddBytes(path.lexically_relative(project).string());
    if (at->is_directory(error)) {
      const bool recorded = fs::exists(path / "journal.jsonl", error);
      const bool take = recorded || fs::exists(path / "curves.json", error);
      if (take && at.depth() == 0)
        (recorded ? takes : edited).push_back(WithoutOddBytes(path.filename().string()));
      if (take || at.depth() >= kMostDepth) at.disable_recursion_pending();
    } else if (files.size() < kMostListed) {
      files.push_back(name);
    }
  }
  for (json* list : {&files, &takes, &edited}) std::sort(list->begin(), list->end());
  answer->update({{"files", files}, {"takes", takes}, {"edited", edited}});
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

ArmatureControl::Listener ListenerFor(SharedProject& project) {
  ArmatureControl::Listener listener;
  static_cast<SessionListener&>(listener) = ToPages(project.hub(), "armature");
  listener.baked = [&project](int code, const std::string& message) {
    project.hub().Send("armature_baked", json{{"exit_code", code}, {"message", message}}.dump());
  };
  // Not before: a take that is there keeps its own puppet if the session was begun with another.
  listener.began = [&project](const ArmatureSetup& setup) {
    try {
      KeepSetupOfTake(project.folder(), setup);
    } catch (const std::exception&) {  // then its puppet is looked for when it is opened
    }
  };
  return listener;
}

}  // namespace

ArmatureRoutes::ArmatureRoutes(SharedProject& project)
    : PageRoutes(project),
      armature_(project.folder(), ListenerFor(project)),
      calibration_(project.folder()) {}

void ArmatureRoutes::AddTo(RouteTable& table) {
  AddSession(table);
  AddViews(table);
  AddCalibration(table);
}

void ArmatureRoutes::AddCalibration(RouteTable& table) {
  table.Get("/api/armature/calibration",
            [this](const Question&) { return JsonAnswer(StoryJson(calibration_.State())); });
  table.Post(
      "/api/armature/calibration/start",
      [this](const Question& question) {
        if (armature_.State().running)
          throw LockedError("a session reads the puppet; end it, then calibrate");
        calibration_.Start(CalibrateSetupFrom(question.Json(), project_.folder()));
        return JsonAnswer(StoryJson(calibration_.State()));
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/calibration/go",
      [this](const Question&) {
        calibration_.Go();
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/calibration/stop",
      [this](const Question&) {
        calibration_.Interrupt();
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
}

void ArmatureRoutes::AddSession(RouteTable& table) {
  const fs::path last = LastSetupFile(project_.folder());
  table.Get("/api/armature", [this, last](const Question&) {
    const ArmatureState story = armature_.State();
    json answer = StoryJson(story);
    answer["baking"] = story.baking;
    answer["ports"] = SerialPorts();
    answer["setup"] = SavedJson(last);
    ListArmature(project_.folder(), &answer);
    return JsonAnswer(answer);
  });
  table.Post(
      "/api/armature/example",
      [this](const Question&) {
        const fs::path example = project_.folder() / "armature/example";
        if (pipeline::RealDisk().LeadsOutside(example, project_.folder()))
          throw UsageError("armature/example leads out of the project");
        if (!fs::exists(example / "set.ply")) {
          const ChildResult made =
              RunChild({(pipeline::ProgramFolder() / "keypose-armature").string(), "example",
                        "--folder", example.string()},
                       project_.folder(), 60);
          if (made.exit_code != 0) throw DiskError(made.output);
        }
        return JsonAnswer(ExampleSetup());
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/start",
      [this, last](const Question& question) {
        const ArmatureSetup setup = ArmatureSetupFrom(question.Json(), project_.folder());
        const fs::path take = armature_.TakeFolder(setup.take);
        if (fs::exists(take / "curves.json") && !fs::exists(take / "journal.jsonl"))
          throw UsageError(fmt::format(
              "{} is a take that was edited, and recording does not go on with it; choose "
              "another name",
              setup.take));
        armature_.Start(setup);
        WriteFileAtomically(last, ArmatureSetupJson(setup).dump());
        return JsonAnswer({{"started", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/command",
      [this](const Question& question) {
        armature_.Say(LineOf(question.Json()));
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/interrupt",
      [this](const Question&) {
        armature_.Interrupt();
        return JsonAnswer({{"sent", true}});
      },
      Changes::kQuietly);
  table.Post(
      "/api/armature/bake",
      [this, last](const Question& question) {
        const json body = question.Json();
        const std::string between = body.at("between");
        if (between != "hold" && between != "linear" && between != "smooth" && between != "keys")
          throw UsageError("between frames it can hold, go linear or smooth; or make keys");
        const json take = body.contains("take") ? body.at("take") : SavedJson(last).at("take");
        armature_.Bake(SetupOfTake(project_.folder(), TakeName(take)), between);
        return JsonAnswer({{"started", true}});
      },
      Changes::kQuietly);
}

void ArmatureRoutes::AddViews(RouteTable& table) {
  // Of the session, or of a take that is named.
  const auto setup = [this](const Question& question) {
    const std::string take = question.Get("take");
    if (!take.empty()) return SetupOfTake(project_.folder(), take);
    return ArmatureSetupFrom(SavedJson(LastSetupFile(project_.folder())), project_.folder());
  };
  const auto page_folder = [this](const Question& question) {
    const std::string take = question.Get("take");
    if (take.empty()) return armature_.PageFolder();
    return TakeEditor(project_.folder()).CharacterFolder(TakeName(take));
  };
  const auto page_file = [page_folder](const Question& question, const char* name) {
    const fs::path file = page_folder(question) / name;
    if (!fs::is_regular_file(file)) throw NotFound("no session has begun");
    return ReadFile(file);
  };
  table.Get("/api/armature/pose", [this](const Question& question) {
    const int after = WholeNumber(question.Get("after", "0"), 0, 2147483647);
    const std::string pose = armature_.Pose(static_cast<std::uint64_t>(after));
    return Answer{200, "application/json", pose.empty() ? "null" : pose, {}, {}};
  });
  table.Get("/api/armature/view", [page_file](const Question& question) {
    return Answer{200, "application/json", page_file(question, "view.json"), {}, {}};
  });
  table.Get("/api/armature/weights", [page_file](const Question& question) {
    return BytesAnswer(page_file(question, "weights.bin"));
  });
  table.Get("/api/armature/frames", [page_file](const Question& question) {
    const std::string all = page_file(question, "frames.bin");
    const auto from =
        static_cast<std::size_t>(WholeNumber(question.Get("from", "0"), 0, 2147483647));
    return BytesAnswer(from < all.size() ? all.substr(from) : "");
  });
  table.Get("/api/armature/mesh", [this, setup, page_folder](const Question& question) {
    const ArmatureSetup now = setup(question);
    const bool set = question.Get("what") == "set";
    const std::string& name = set ? now.set : now.mesh;
    if (set && name.empty()) throw NotFound("the set has no geometry");
    return BytesAnswer(MeshBytes(
        ReadMesh(name.empty() ? page_folder(question) / "rest.ply" : project_.folder() / name)));
  });
  table.Get("/api/armature/texture", [this, setup](const Question& question) {
    const ArmatureSetup now = setup(question);
    if (now.texture.empty()) throw NotFound("the character has no texture");
    return PictureAnswer(PictureFile(project_.PictureFolder(), project_.folder() / now.texture, 0));
  });
  table.Get("/api/armature/plate", [this, page_file](const Question& question) {
    const int index = WholeNumber(question.Get("index", "0"), 0, 1000000);
    const json pictures = json::parse(page_file(question, "view.json")).at("pictures");
    if (pictures.empty()) throw NotFound("there is no plate");
    const fs::path file =
        pictures.at(std::min(static_cast<std::size_t>(index), pictures.size() - 1))
            .get<std::string>();
    if (pipeline::RealDisk().LeadsOutside(file, project_.folder()))
      throw NotFound("the plate leads out of the project");
    return PictureAnswer(PictureFile(project_.PictureFolder(), file, 0));
  });
}

}  // namespace keypose::studio
