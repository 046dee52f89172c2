// `keypose armature simulate`: a controller box without hardware, on a pseudo terminal.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <random>
#include <sstream>

#include "armature/armature_commands.h"
#include "armature/controller/steady_clock.h"
#include "armature/example/theropod.h"
#include "armature/puppet.h"
#include "armature/recording/curve_edits.h"
#include "armature/recording/joint_curves.h"
#include "armature/simulation/simulated_box.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

struct SimulateFlags {
  std::string description, link, curves, faults;
  double fps = 12, play = 0, gear_error = 0;
  int boot = 1;
};

/// Joint values of a frame: of recorded curves, or of the example's motion.
class Motion {
 public:
  Motion(const Armature& armature, const SimulateFlags& flags)
      : armature_(armature), fps_(flags.fps) {
    if (!flags.curves.empty())
      curves_ = ParseCurvesJson(ReadFile(flags.curves), PrintableName(flags.curves), armature);
  }
  std::vector<double> At(double frame) const {
    if (curves_.frame_count() == 0) return ExampleMotion(armature_, frame / fps_);
    const int last = curves_.frame_count() - 1;
    const auto row = curves_.values.row(std::clamp(static_cast<int>(frame), 0, last)).eval();
    return {row.data(), row.data() + row.size()};
  }

 private:
  const Armature& armature_;
  double fps_;
  JointCurves curves_;
};

/// Carries out what is typed.
class Stage {
 public:
  Stage(const Armature& armature, const SimulateFlags& flags, SimulatedBox& box)
      : armature_(armature), motion_(armature, flags), box_(box), values_(armature.joints.size()) {
    if (flags.play > 0) Play(flags.play);
  }

  /// @return false for `end`
  bool Do(const std::string& line) {
    std::istringstream words(line);
    std::string word, name;
    double number = 0;
    words >> word;
    if (word == "end") return false;
    if (word == "frame" && words >> number) return Frame(static_cast<int>(number));
    if (word == "zero") return Move(std::vector<double>(armature_.joints.size()));
    if (word == "put" && words >> name >> number) return Put(name, number);
    if (word == "play") return Play(words >> number ? number : motion_fps_);
    if (word == "stop") return Play(0);
    if (word == "mend" && words >> name) return Mend(name);
    if (word == "fault" && words >> name) return Fault(name);
    fmt::print("not understood: {}\n", line);
    return true;
  }

  void Tick() {
    if (speed_ > 0) box_.SetValues(motion_.At(speed_ * (SteadySeconds() - began_s_)));
    if (!tells_arrival_ || !box_.at_rest()) return;
    tells_arrival_ = false;
    fmt::print("at rest\n");
    std::fflush(stdout);
  }

 private:
  bool Move(const std::vector<double>& values) {
    speed_ = 0;
    values_ = values;
    box_.MoveTo(values);
    tells_arrival_ = true;
    return true;
  }
  bool Frame(int frame) {
    box_.BeginFrame(frame);
    return Move(motion_.At(frame));
  }
  /// One joint to a number of degrees; a slide's is in the description's unit.
  bool Put(const std::string& name, double number) {
    const int joint = Joint(name);
    if (joint < 0) return true;
    values_[static_cast<std::size_t>(joint)] = number * EditUnitOf(armature_, joint).size;
    return Move(values_);
  }
  bool Play(double frames_a_second) {
    speed_ = frames_a_second;
    began_s_ = SteadySeconds();
    return true;
  }
  bool Mend(const std::string& name) {
    if (const int joint = Joint(name); joint >= 0) box_.Mend(Node(joint).sensor);
    return true;
  }
  bool Fault(const std::string& name) {
    try {
      box_.Make(ParseFaults(name + "@0", armature_).at(0));
    } catch (const UsageError& error) {
      fmt::print("{}\n", error.what());
    }
    return true;
  }
  const ArmatureNode& Node(int joint) const {
    return armature_
        .nodes[static_cast<std::size_t>(armature_.joints[static_cast<std::size_t>(joint)])];
  }
  int Joint(const std::string& name) const {
    const int node = armature_.Find(name);
    const int joint = node < 0 ? -1 : armature_.JointOf(node);
    if (joint < 0) fmt::print("no joint is named {}\n", name);
    return joint;
  }

  const Armature& armature_;
  Motion motion_;
  SimulatedBox& box_;
  std::vector<double> values_;
  double speed_ = 0, began_s_ = 0, motion_fps_ = 12;
  bool tells_arrival_ = false;
};

int Simulate(const SimulateFlags& flags) {
  const Armature armature = LoadArmature(flags.description);
  SimulationOptions options;
  options.faults = ParseFaults(flags.faults, armature);
  options.boot = flags.boot;
  std::mt19937 random(1);
  for (std::size_t j = 0; j < armature.joints.size(); ++j)
    options.gears.push_back(1 + flags.gear_error *
                                    (2 * static_cast<double>(random()) / 4294967295.0 - 1));
  SimulatedBox box(armature, std::filesystem::absolute(flags.link), options);
  fmt::print("{} sensors on {}\n", armature.joints.size(), flags.link);
  std::fflush(stdout);
  Stage stage(armature, flags, box);
  LineInput input(STDIN_FILENO);
  while (!WasInterrupted()) {
    if (const auto line = input.Next(0.005); line && !stage.Do(*line)) break;
    stage.Tick();
  }
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace

int SimulateCommand(int argc, char** argv) {
  CLI::App app("A controller box without hardware: other subcommands read it by --port LINK.",
               "keypose armature simulate");
  SimulateFlags flags;
  app.add_option("--description", flags.description, "the armature's description file")->required();
  app.add_option("--link", flags.link, "name of the port that is made")->required();
  app.add_option("--curves", flags.curves,
                 "recorded curves (.json) to move by; default: a walk, or a swing of all joints");
  app.add_option("--fps", flags.fps, "frames a second of the default motion")
      ->check(CLI::Range(0.1, 1000.0))
      ->capture_default_str();
  app.add_option("--play", flags.play, "move at once, by so many frames a second")
      ->check(CLI::Range(0.0, 1000.0));
  app.add_option("--faults", flags.faults,
                 "such as drop@5,stuck:leftKneeBend@20; kinds: drop noise glitch:JOINT wrap "
                 "stuck:JOINT lost:JOINT unplug power");
  app.add_option("--gear-error", flags.gear_error,
                 "true gear ratios differ from the description's by up to this share")
      ->check(CLI::Range(0.0, 0.4));
  app.add_option("--boot", flags.boot, "number of its first power-up")->check(CLI::Range(1, 65000));
  app.footer(
      "While it runs, type and press Enter: frame N | put JOINT DEGREES | zero | play [FPS] | "
      "stop | fault KIND[:JOINT] | mend JOINT | end");
  return RunCommandLine(app, argc, argv, [&] { return Simulate(flags); });
}

}  // namespace keypose::armature
