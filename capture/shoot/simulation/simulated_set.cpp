#include "capture/shoot/simulation/simulated_set.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "capture/shoot/devices/grbl_turntable.h"
#include "capture/shoot/devices/steps_turntable.h"
#include "core/values/errors.h"

extern char** environ;

namespace keypose::capture::shoot {
namespace {

namespace fs = std::filesystem;

/// Poses that `keypose synth` can draw; another pose's name gets the first.
const std::vector<std::string> kDrawable = {"rest",   "bent",  "wave", "bow",
                                            "squash", "twist", "hip"};

/// Runs a program, and waits for it.
void RunProgram(const fs::path& program, std::vector<std::string> arguments) {
  std::vector<char*> words;
  std::string name = program.string();
  words.push_back(name.data());
  for (std::string& argument : arguments) words.push_back(argument.data());
  words.push_back(nullptr);
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, STDIN_FILENO, "/dev/null", 0, 0);
  posix_spawn_file_actions_adddup2(&quiet, STDERR_FILENO, STDOUT_FILENO);
  pid_t child = 0;
  const int error = posix_spawn(&child, name.c_str(), &quiet, nullptr, words.data(), environ);
  posix_spawn_file_actions_destroy(&quiet);
  if (error != 0) throw ToolError("cannot start " + name + ": " + std::strerror(error));
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw ToolError(name + " could not draw the simulated photographs");
}

std::string TextOf(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ",") + std::to_string(value);
  return text;
}

}  // namespace

SimulatedSet::SimulatedSet(const fs::path& folder, const std::string& faults)
    : folder_(folder), faults_(ParseFaults(faults)) {}

SimulatedSet::~SimulatedSet() = default;

SimulatedWorld& SimulatedSet::World() {
  if (!world_) {
    std::error_code error;
    fs::create_directories(folder_, error);
    if (error) throw DiskError("cannot make " + folder_.string() + ": " + error.message());
    world_ = std::make_unique<SimulatedWorld>(folder_ / "world.json");
  }
  return *world_;
}

std::unique_ptr<CameraDevice> SimulatedSet::MakeCamera(const std::string& drawn) {
  drawn_ = drawn.empty() ? fs::path() : fs::absolute(drawn);
  auto camera = MakeSimulatedCamera(World(), faults_);
  camera_ = camera.get();
  return camera;
}

std::unique_ptr<TurntableDevice> SimulatedSet::MakeTurntable(const std::string& protocol) {
  constexpr int kStepsATurn = 3200;
  const bool grbl = protocol == "grbl";
  const fs::path port = folder_ / "port";
  FirmwareOptions options;
  options.boot = ::getpid();  // power came back with this process
  SimulatedWorld& world = World();
  firmware_ = std::make_unique<Firmware>(grbl ? MakeGrblFirmware() : MakeStepsFirmware(kStepsATurn),
                                         world, faults_, port, options);
  // A simulated controller answers at once; no need to wait for it as long as for a real one.
  if (grbl) {
    GrblTimes times;
    times.wake_up_s = 0.5;
    times.reply_s = 0.4;
    times.ask_s = 0.01;
    times.stall_s = 0.5;
    GrblOptions fast;
    fast.speed_deg_s = options.speed_deg_s;
    return MakeGrblTurntable(port, fast, times);
  }
  StepsTimes times;
  times.reply_s = 0.1;
  times.ask_s = 0.01;
  times.stall_s = 0.5;
  return MakeStepsTurntable(port, times);
}

fs::path SimulatedSet::Draw(const std::string& pose, const DrawnPlan& plan) const {
  const bool known = std::find(kDrawable.begin(), kDrawable.end(), pose) != kDrawable.end();
  const std::string drawn = known ? pose : kDrawable.front();
  const fs::path folder = folder_ / ("drawn_" + drawn), beside = folder.string() + ".part";
  if (fs::exists(folder)) return folder / "photos" / drawn;
  std::error_code ignored;
  fs::remove_all(beside, ignored);
  std::vector<std::string> arguments = {
      "photos",
      "--output",
      beside,
      "--poses",
      drawn,
      "--width",
      "480",
      "--views",
      std::to_string(plan.angles * static_cast<int>(plan.rings_deg.size())),
      "--elevations",
      TextOf(plan.rings_deg)};
  if (plan.lying) arguments.push_back("--flip");
  RunProgram(fs::read_symlink("/proc/self/exe").parent_path() / "keypose-synth", arguments);
  fs::rename(beside, folder);
  return folder / "photos" / drawn;
}

void SimulatedSet::PoseBegins(const std::string& pose, const DrawnPlan& plan) {
  if (!camera_) return;
  fs::path folder;
  if (drawn_.empty())
    folder = Draw(pose, plan);
  else
    folder = fs::exists(drawn_ / "photos" / pose) ? drawn_ / "photos" / pose : drawn_;
  if (!fs::exists(folder / "IMG_0001.jpg"))
    throw UsageError("--camera simulated: " + folder.string() +
                     " has no photographs of `keypose synth photos`");
  camera_->SetPose({folder, plan.angles});
  if (World().pose() != pose) World().SetFigure(pose, 0);
}

void SimulatedSet::DoneByHand(const std::string& ask, int ring, int flip, double angle_deg) {
  if (!world_) return;
  if (ask == "camera-height") world_->SetCamera(ring);
  if (ask == "flip") world_->SetFigure(world_->pose(), flip);
  if (ask == "turn" || ask == "table-angle") world_->SetTable(angle_deg);
}

}  // namespace keypose::capture::shoot
