// The program `keypose`: its own commands, and `keypose STAGE ...`, which executes keypose-STAGE.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <functional>
#include <system_error>
#include <utility>

#include "pipeline/commands/keypose_commands.h"
#include "pipeline/graph/stage_info.h"
#include "pipeline/run/opened_project.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kCommands = {"init",   "run",   "status", "explain",
                                            "log",    "graph", "gc",     "verify",
                                            "unlock", "pack",  "report", "doctor"};

/// Commands that are programs of their own, and what they are for.
const std::vector<std::pair<std::string, std::string>> kProgramCommands = {
    {"studio", "open the project in a web page"},
    {"shoot", "photograph poses with a camera and a turntable"},
    {"figure", "say what the figure is, where the photographs cannot tell"},
    {"cameras", "write the cameras of a pose for COLMAP, nerfstudio or Metashape"}};

std::vector<std::string> StageNames() {
  std::vector<std::string> names;
  for (const std::string& name : RealDisk().Children(ProgramFolder())) {
    const bool stage =
        std::none_of(kProgramCommands.begin(), kProgramCommands.end(),
                     [&](const auto& own) { return name == "keypose-" + own.first; });
    if (name.starts_with("keypose-") && stage) names.push_back(name.substr(8));
  }
  return names;
}

bool IsCommand(const std::string& word) {
  return std::find(kCommands.begin(), kCommands.end(), word) != kCommands.end();
}

bool IsStage(const std::string& word) {
  return access((ProgramFolder() / ("keypose-" + word)).c_str(), X_OK) == 0;
}

/// `keypose report` shows the project's report; with the stage's flags it runs the stage `report`.
bool MeansStage(int argc, char** argv) {
  if (argc < 2 || argv[1][0] == '-') return false;
  const std::string word = argv[1];
  if (!IsCommand(word)) return true;
  if (!IsStage(word)) return false;
  for (int i = 2; i < argc; ++i) {
    const std::string argument = argv[i], flag = argument.substr(0, argument.find('='));
    if (flag.starts_with("--") && flag != "--folder" && flag != "--help") return true;
  }
  return false;
}

[[noreturn]] void Become(const fs::path& program, char** argv) {
  execv(program.c_str(), argv);
  throw ToolError(fmt::format("cannot start {}: {}", program.string(), std::strerror(errno)));
}

/// @throws ToolError  the word is a command whose program was not built or installed
void RequireProgram(const std::string& word) {
  for (const auto& [command, purpose] : kProgramCommands)
    if (command == word)
      throw ToolError(fmt::format(
          "the program keypose-{} is not beside keypose, in {}; among the sources, `./dev build` "
          "makes all programs",
          word, ProgramFolder().string()));
}

[[noreturn]] void BecomeStage(char** argv) {
  const fs::path program = ProgramFolder() / (std::string("keypose-") + argv[1]);
  if (!IsStage(argv[1])) {
    RequireProgram(argv[1]);
    std::vector<std::string> known = kCommands;
    for (const auto& own : kProgramCommands) known.push_back(own.first);
    for (const std::string& stage : StageNames()) known.push_back(stage);
    throw UsageError(
        fmt::format("'{}' is neither a command nor a stage{}; `keypose --help` lists all", argv[1],
                    Suggestion(argv[1], known)));
  }
  argv[1] = const_cast<char*>(program.c_str());
  Become(program, argv + 1);
}

/// Of a command; where a stage has the same name, also of that.
ExitCode ShowHelp(const CLI::App& command) {
  fmt::print("{}", command.help("keypose"));
  if (!IsStage(command.get_name())) return ExitCode::kOk;
  fmt::print("\nThe stage of that name, which flags of its own run alone:\n\n");
  std::fflush(stdout);
  const fs::path program = ProgramFolder() / ("keypose-" + command.get_name());
  std::string name = program.string(), flag = "--help";
  char* words[] = {name.data(), flag.data(), nullptr};
  Become(program, words);
}

/// A hint for commands such as `keypose run puppet`.
std::string FolderHint(int argc, char** argv) {
  std::error_code ignored;
  for (int i = 2; i < argc; ++i) {
    if (!fs::is_regular_file(fs::path(argv[i]) / "pipeline.yaml", ignored)) continue;
    return fmt::format("; a project's folder is named with -C, as in -C {}", ShellWord(argv[i]));
  }
  return "";
}

/// All commands with their flags. `chosen` is set to the one that was given.
class CommandLine {
 public:
  CommandLine(int argc, char** argv)
      : app_("Keypose: photographs of key poses in, a textured, animated character out.",
             "keypose") {
    for (int i = 0; i < argc; ++i)
      run_.command_line += (i ? " " : "") + std::string(i ? argv[i] : "keypose");
    app_.require_subcommand(0, 1);
    app_.add_flag("--version", version_,
                  "versions of keypose and of the programs and libraries it uses");
    std::string stages;
    for (const std::string& stage : StageNames()) stages += " " + stage;
    app_.footer("Stages, which can also be run alone (keypose STAGE --help):" + stages);
    AddInit();
    AddRun();
    AddLookers();
    AddLater();
  }

  ExitCode Run(int argc, char** argv) {
    try {
      app_.parse(argc, argv);
    } catch (const CLI::CallForHelp&) {
      for (const CLI::App* command : app_.get_subcommands()) return ShowHelp(*command);
      fmt::print("{}", app_.help());
      return ExitCode::kOk;
    } catch (const CLI::ParseError& error) {
      throw UsageError(fmt::format("{}{}; see `keypose --help` or `keypose COMMAND --help`",
                                   error.what(), FolderHint(argc, argv)));
    }
    if (version_) return VersionCommand();
    if (chosen_) return chosen_();
    fmt::print("{}", app_.help());
    return ExitCode::kUsage;
  }

 private:
  CLI::App* Command(const std::string& name, const std::string& help,
                    std::function<ExitCode()> action) {
    CLI::App* command = app_.add_subcommand(name, help);
    command->callback([this, action = std::move(action)] { chosen_ = action; });
    return command;
  }
  CLI::App* InProject(CLI::App* command) {
    command->add_option("-C,--folder", run_.folder,
                        "the project's folder; default: the current folder or the nearest parent "
                        "with a pipeline.yaml");
    return command;
  }
  void TakesSet(CLI::App* command) {
    command
        ->add_option("--set", run_.set,
                     "STEP.OPTION=V or STEP/POSE.OPTION=V, for this command only")
        ->allow_extra_args(false);
  }

  void AddInit() {
    CLI::App* init = Command("init", "make a project", [this] {
      if (init_.kind == "performance") return InitPerformance(init_);
      RequireNoPerformance(init_);
      return NamesMesh(init_) ? InitMeshes(init_) : InitCommand(init_);
    });
    init->add_option("DIR", init_.folder, "folder to make")->required();
    init->add_option(
            "--pose", init_.poses,
            "NAME=PHOTO_DIR; the photographs are copied. Or NAME=MESH for all poses: "
            "meshes made elsewhere (.obj, .ply, .off, .stl, .glb, .gltf, or one of them in a "
            ".zip), with their textures")
        ->allow_extra_args(false);
    init->add_option("--template", init_.template_pose,
                     "the pose whose mesh and UVs all others take; default: the first");
    init->add_option("--few", init_.few,
                     "NAME: this pose has few photographs, which the template is fitted to; "
                     "default: poses with fewer than 16, other than the template")
        ->allow_extra_args(false);
    init->add_option("--scan", init_.scan,
                     "NAME: this pose is scanned from its own photographs all round, however few")
        ->allow_extra_args(false);
    init->add_option(
        "--film", init_.film,
        "a filmed shot, which in-betweens go into: a folder of numbered pictures, or a "
        "video (.mp4, .mov); it stays where it is");
    init->add_option("--shows", init_.shows,
                     "FRAME=POSE, separated by commas: which frames of the film show which pose")
        ->delimiter(',');
    init->add_option("--film-fps", init_.film_fps,
                     "filmed frames a second; default: those of a video, else 12");
    init->add_option("--plate", init_.plate, "a picture of the film's set without the character");
    init->add_option("--mattes", init_.mattes,
                     "a folder with a matte for each filmed frame: white is the character");
    init->add_option("--holdout", init_.holdout,
                     "a picture that is white where props stand before the character");
    init->add_option("--kind", init_.kind,
                     "poses: key poses and frames between them; performance: a scan that moves as "
                     "an actor in films")
        ->check(CLI::IsMember({"poses", "performance"}))
        ->capture_default_str();
    init->add_option("--shot", init_.shots,
                     "performance: NAME=FOLDER of one video or picture folder for each camera; "
                     "films stay where they are")
        ->allow_extra_args(false);
    init->add_option("--calibration", init_.calibration,
                     "performance: the cameras of all shots; default: calibration.* in each shot");
    init->add_option("--scan-mesh", init_.scan_mesh, "performance: the mesh that shall move");
    init->add_option("--texture", init_.texture,
                     "performance: its texture; poses from meshes: that of the template, whose "
                     "texture coordinates stay");
    init->add_flag("--same-faces", init_.same_faces,
                   "poses from meshes: all have the same vertices and faces already");
    init->add_option("--marks", init_.marks,
                     "performance: pairs of places on the tracked body and on the mesh");
    init->add_flag("--surface", init_.surface,
                   "performance: bend what moves into the films, frame by frame");
    init->add_flag("--video3d", init_.video3d,
                   "performance: paint what moves from the films, frame by frame");
  }

  void AddRun() {
    CLI::App* run = InProject(
        Command("run", "make everything that is not up to date", [this] { return RunChecked(); }));
    Selection& selection = run_.selection;
    run->add_option(
           "--from", selection.from,
           "only this step and the steps that follow; earlier results are used as last made")
        ->allow_extra_args(false);
    run->add_option("--until", selection.until, "only this step and the steps that it needs")
        ->allow_extra_args(false);
    run->add_option("--only", selection.only, "only this step")->allow_extra_args(false);
    run->add_option("--force", selection.force, "run this step even if it is up to date")
        ->allow_extra_args(false);
    run->add_flag("--dry-run", run_.dry_run, "show what would run, and why");
    run->add_option("-j,--jobs", run_.cores, "cores for all steps together; default: all")
        ->check(CLI::Range(1, 4096));
    run->add_option("--progress", run_.progress, "bars, lines or jsonl")
        ->check(CLI::IsMember({"bars", "lines", "jsonl"}));
    run->add_option("--executor", executor_, "local (slurm is not part of this version)");
    TakesSet(run);
  }

  ExitCode RunChecked() {
    if (executor_ == "slurm")
      throw UsageError(
          "--executor slurm: this version of keypose runs on one machine only; leave the flag out");
    if (executor_ != "local")
      throw UsageError(fmt::format("--executor {}: only local is known", executor_));
    return RunCommand(run_);
  }

  void AddLookers() {
    CLI::App* status =
        InProject(Command("status", "show which steps are up to date, and the verdicts",
                          [this] { return StatusCommand(run_.folder, run_.set, details_); }));
    status->add_flag("--details", details_, "verdicts in full");
    TakesSet(status);
    CLI::App* explain =
        InProject(Command("explain", "show why a step would run, or last ran",
                          [this] { return ExplainCommand(run_.folder, step_, run_.set); }));
    TakesSet(explain);
    CLI::App* log = InProject(Command("log", "show the last log of a step",
                                      [this] { return LogCommand(run_.folder, step_); }));
    for (CLI::App* command : {explain, log})
      command->add_option("STEP", step_, "STEP or STEP/POSE")->required();
    CLI::App* graph = InProject(Command("graph", "show the steps and the data between them",
                                        [this] { return GraphCommand(run_.folder, dot_); }));
    graph->add_flag("--dot", dot_, "for Graphviz");
    CLI::App* gc = InProject(Command("gc", "remove cached results that nothing refers to", [this] {
      return GcCommand(run_.folder, run_.dry_run, keep_runs_);
    }));
    gc->add_flag("--dry-run", run_.dry_run, "only say how much");
    gc->add_option("--keep-runs", keep_runs_, "keep the results of this many last runs")
        ->check(CLI::Range(0, 100000))
        ->capture_default_str();
    InProject(Command("verify", "read the whole cache and out/, and remove what is damaged",
                      [this] { return VerifyCommand(run_.folder); }));
    CLI::App* pack = InProject(
        Command("pack", "write the project into one ZIP file, for another machine or the shelf",
                [this] { return PackCommand(run_.folder, packed_, !without_cache_); }));
    pack->add_option("-o,--output", packed_, "the file; default: the project's name and .zip");
    pack->add_flag("--without-cache", without_cache_,
                   "smaller; where it is unpacked, all steps run once again");
    CLI::App* unlock =
        InProject(Command("unlock", "show who holds the project's lock, and clear a stale one",
                          [this] { return UnlockCommand(run_.folder, force_); }));
    unlock->add_flag("--force", force_, "also remove the lock of a machine that no longer exists");
    InProject(Command("report", "show where the project's report is",
                      [this] { return ReportCommand(run_.folder); }));
    Command("doctor", "check programs and libraries", [] { return DoctorCommand(); });
  }

  void AddLater() {
    for (const auto& [name, help] : kProgramCommands)
      Command(name, help, [program = "keypose-" + name]() -> ExitCode {
        throw ToolError(program + " is missing; install keypose again");
      })->allow_extras();
  }

  CLI::App app_;
  std::function<ExitCode()> chosen_;
  RunOptions run_;
  InitOptions init_;
  std::string step_, packed_, executor_ = "local";
  bool details_ = false;
  bool version_ = false, dot_ = false, force_ = false, without_cache_ = false;
  int keep_runs_ = 10;
};

void Complain(const std::string& line) { std::fputs(("keypose: " + line + "\n").c_str(), stderr); }

int Bug(const std::exception& error) {
  Complain(fmt::format("a bug: {}\nplease report it, with your command", error.what()));
  return static_cast<int>(ExitCode::kBug);
}

int Main(int argc, char** argv) {
  try {
    if (MeansStage(argc, argv)) BecomeStage(argv);
    return static_cast<int>(CommandLine(argc, argv).Run(argc, argv));
  } catch (const Error& error) {
    std::fflush(stdout);
    Complain(
        fmt::format("{}{}", error.code() == ExitCode::kInterrupted ? "" : "error: ", error.what()));
    return static_cast<int>(error.code());
  } catch (const std::system_error& error) {
    // The reader of our output closed the pipe, as `head` does.
    if (error.code() == std::errc::broken_pipe) return static_cast<int>(ExitCode::kOk);
    return Bug(error);
  } catch (const std::exception& error) {
    return Bug(error);
  }
}

}  // namespace
}  // namespace keypose::pipeline

int main(int argc, char** argv) { return keypose::pipeline::Main(argc, argv); }
