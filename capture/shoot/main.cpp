// The program `keypose shoot`: photographs one pose after the other into a project.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "capture/shoot/devices/folder_camera.h"
#include "capture/shoot/devices/gphoto2_camera.h"
#include "capture/shoot/devices/grbl_turntable.h"
#include "capture/shoot/devices/steps_turntable.h"
#include "capture/shoot/session/shooting_session.h"
#include "capture/shoot/session/white_card.h"
#include "capture/shoot/simulation/simulated_set.h"
#include "capture/shoot/talk/json_lines.h"
#include "capture/shoot/talk/terminal_conversation.h"
#include "core/io/text/line_input.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

struct Flags {
  std::string folder = ".", camera = "gphoto2", turntable = "none", white_balance, axis = "X";
  std::string faults, world;
  ShootingOptions session;
  GrblOptions grbl;
  bool commands = false;
};

void AddFlags(CLI::App& app, Flags& flags) {
  app.add_option("-C,--folder", flags.folder,
                 "the project's folder; made if it is not there; default: this folder");
  app.add_option("--pose", flags.session.pose, "name of the pose to photograph")->required();
  app.add_option("--camera", flags.camera,
                 "gphoto2 | folder:PATH (filled by a tethering program) | simulated[:PATH]")
      ->capture_default_str();
  app.add_option("--turntable", flags.turntable,
                 "none (turned by hand) | grbl:DEV | steps:DEV | simulated[:grbl]")
      ->capture_default_str();
  app.add_option("--rings", flags.session.plan.rings_deg,
                 "elevations of the camera above the table, lowest first [deg]")
      ->delimiter(',')
      ->capture_default_str();
  app.add_option("--angles", flags.session.plan.angles,
                 "photographs of each ring; of a pose after the first 6 suffice, in one ring")
      ->capture_default_str();
  app.add_option("--flips", flags.session.plan.flips,
                 "further times with the figure laid on another side, 0 to 3")
      ->capture_default_str();
  app.add_option("--focus-stack", flags.session.plan.focus_stack,
                 "photographs of each angle with different focus, merged into one")
      ->capture_default_str();
  app.add_option("--again", flags.session.again,
                 "an angle of the first ring at work, or a photograph such as r2_a045, to be shot "
                 "again first");
  app.add_option("--settle", flags.session.settle_s, "rest of the table before a photograph [s]")
      ->check(CLI::Range(0.0, 600.0))
      ->capture_default_str();
  app.add_option("--white-balance", flags.white_balance,
                 "FILE:x,y,w,h: a photograph of a grey card and its place in pixels; FILE: the "
                 "card is searched; none: forget it");
  app.footer(
      "While it runs, type and press Enter: (only Enter) go on | again 45 | skip | pause | at 45 | "
      "next NAME | end. It may be interrupted at any moment; the same command goes on.");
}

void AddDeviceFlags(CLI::App& app, Flags& flags) {
  app.add_option("--axis", flags.axis, "the table's axis of a GRBL controller")
      ->check(CLI::IsMember({"X", "Y", "Z"}))
      ->capture_default_str();
  app.add_option("--degrees-per-unit", flags.grbl.degrees_per_unit,
                 "how far a GRBL table turns for one unit [deg]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--speed", flags.grbl.speed_deg_s, "of a GRBL table [deg/s]")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_flag("--commands", flags.commands,
               "JSON lines on stdin and stdout, for programs; see docs/shoot.md");
  app.add_option("--live", flags.session.live_file, "file for the frames of the live view (.jpg)");
  app.add_option("--faults", flags.faults,
                 "of simulated devices, such as lost-reply@5,card-full@9: at the fifth turn, the "
                 "ninth photograph");
  app.add_option("--world", flags.world,
                 "folder of the simulated set; default: .keypose/shoot/simulated in the project");
}

/// "grbl:/dev/ttyUSB0" in two; the second is empty without a colon.
std::pair<std::string, std::string> Split(const std::string& text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos) return {text, ""};
  return {text.substr(0, colon), text.substr(colon + 1)};
}

std::unique_ptr<CameraDevice> MakeCamera(const Flags& flags, SimulatedSet* simulated) {
  const auto [kind, path] = Split(flags.camera);
  if (kind == "gphoto2" && path.empty()) return MakeGphoto2Camera();
  if (kind == "folder" && !path.empty()) return MakeFolderCamera(fs::absolute(path));
  if (kind == "simulated") return simulated->MakeCamera(path);
  throw UsageError(fmt::format("--camera {}: it must be gphoto2, folder:PATH or simulated[:PATH]",
                               flags.camera));
}

std::unique_ptr<TurntableDevice> MakeTurntable(Flags& flags, SimulatedSet* simulated) {
  const auto [kind, path] = Split(flags.turntable);
  flags.session.turntable_name = kind;
  flags.grbl.axis = flags.axis.front();
  if (kind == "none" && path.empty()) return nullptr;
  if (kind == "grbl" && !path.empty()) return MakeGrblTurntable(path, flags.grbl);
  if (kind == "steps" && !path.empty()) return MakeStepsTurntable(path);
  if (kind == "simulated" && (path.empty() || path == "grbl" || path == "steps"))
    return simulated->MakeTurntable(path);
  throw UsageError(fmt::format(
      "--turntable {}: it must be none, grbl:DEV, steps:DEV or simulated[:grbl]", flags.turntable));
}

/// Flags that need more than their own check.
void Settle(CLI::App& app, Flags& flags) {
  ShootingOptions& session = flags.session;
  if (const auto problems = session.plan.Problems(); !problems.empty())
    throw UsageError(problems.front());
  for (const char* flag : {"--rings", "--angles", "--flips", "--focus-stack"})
    session.plan_given = session.plan_given || app.count(flag) > 0;
  session.rings_given = app.count("--rings") > 0;
  session.project = fs::absolute(flags.folder).lexically_normal();
  if (!session.project.has_filename()) session.project = session.project.parent_path();
  if (!session.live_file.empty()) session.live_file = fs::absolute(session.live_file);
  session.forget_white = flags.white_balance == "none";
  if (!flags.white_balance.empty() && !session.forget_white)
    session.white = WhiteOfCard(flags.white_balance);
  const bool person = isatty(STDIN_FILENO);
  const bool trial = flags.camera.starts_with("simulated");
  session.begins_at_once = !flags.commands;
  session.answers_itself = trial && !flags.commands && !person;
  session.waits_for_devices = session.stays_when_complete = flags.commands || person;
  if (trial && flags.turntable.starts_with("simulated")) session.settle_s = 0;
  if (trial) session.retry_s = 0.2;
}

int Shoot(Flags& flags) {
  std::error_code error;
  fs::create_directories(flags.session.project, error);
  if (error)
    throw DiskError(fmt::format("cannot make the folder {}: {}", flags.session.project.string(),
                                error.message()));
  const fs::path world = flags.world.empty()
                             ? flags.session.project / ".keypose" / "shoot" / "simulated"
                             : fs::absolute(flags.world);
  SimulatedSet simulated(world, flags.faults);
  const std::unique_ptr<CameraDevice> camera = MakeCamera(flags, &simulated);
  const std::unique_ptr<TurntableDevice> turntable = MakeTurntable(flags, &simulated);
  const std::unique_ptr<Conversation> talk = flags.commands
                                                 ? MakeJsonLines(STDIN_FILENO, STDOUT_FILENO)
                                                 : MakeTerminal(STDIN_FILENO, STDOUT_FILENO);
  const SystemClock clock;
  const ShootingParts parts{
      *camera,
      turntable.get(),
      *talk,
      clock,
      [&](const std::string& ask, const Shot& shot, double angle_deg) {
        simulated.DoneByHand(ask, shot.ring, shot.flip, angle_deg);
      },
      [&](const std::string& pose, const ShotPlan& plan) {
        simulated.PoseBegins(pose, {plan.rings_deg, plan.angles, plan.flips > 0});
      }};
  RunShootingSession(flags.session, parts);
  return static_cast<int>(ExitCode::kOk);
}

int Fail(const Flags& flags, const Error& error) {
  if (flags.commands) {
    const auto talk = MakeJsonLines(STDIN_FILENO, STDOUT_FILENO);
    talk->Tell({{"event", "ended"}, {"complete", false}, {"words", error.what()}});
  }
  const bool interrupted = error.code() == ExitCode::kInterrupted;
  fmt::print(stderr, "keypose: {}{}\n", interrupted ? "" : "error: ", error.what());
  if (interrupted) fmt::print(stderr, "keypose: the same command goes on\n");
  return static_cast<int>(error.code());
}

int Main(int argc, char** argv) {
  CLI::App app(
      "Photographs one pose after the other: drives camera and turntable, checks each "
      "photograph as it lands, says what to do next.",
      "keypose shoot");
  Flags flags;
  AddFlags(app, flags);
  AddDeviceFlags(app, flags);
  try {
    app.parse(argc, argv);
    CatchInterrupts();
    Settle(app, flags);
    return Shoot(flags);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return 0;
  } catch (const CLI::ParseError& error) {
    fmt::print(stderr, "keypose: error: {}; see `keypose shoot --help`\n", error.what());
    return static_cast<int>(ExitCode::kUsage);
  } catch (const Error& error) {
    return Fail(flags, error);
  }
}

}  // namespace
}  // namespace keypose::capture::shoot

int main(int argc, char** argv) { return keypose::capture::shoot::Main(argc, argv); }
