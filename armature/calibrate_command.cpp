// `keypose armature calibrate`: the zero position, its check, gear ratios from known angles.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "armature/armature_commands.h"
#include "armature/controller/gear_fit.h"
#include "armature/controller/steady_clock.h"
#include "armature/description/description_file.h"
#include "armature/puppet.h"
#include "armature/recording/curve_edits.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

struct CalibrateFlags {
  PuppetFlags puppet;
  bool verify = false, wiggle = false, asks = true, keeps_counters = false, page = false;
  std::string known, written;
  double tolerance_deg = 0.5;
};

constexpr int kWiggleCounts = 20;
constexpr double kTwoReadings_s = 0.5;

/// The conversation of one calibration.
class Calibrator {
 public:
  Calibrator(const CalibrateFlags& flags, Puppet& puppet)
      : flags_(flags), puppet_(puppet), input_(STDIN_FILENO) {}

  /// Sets all joints and counters to zero.
  void SetZero() {
    TellFresh();
    Ask("put the puppet into its zero position: spine and legs straight, against their blocks");
    RequireRest();
    if (flags_.keeps_counters)
      for (std::size_t j = 0; j < Values().size(); ++j) puppet_.reader().SetValue(j, 0);
    else
      puppet_.reader().ResetCounters();
    Pass(kTwoReadings_s);
    for (std::size_t j = 0; j < Values().size(); ++j)
      if (std::abs(Counts(j)) > 1)
        throw ToolError(
            fmt::format("{} stands at {} counts after the reset; it moved, or its card "
                        "does not obey: begin again",
                        Name(j), Counts(j)));
    Say(fmt::format("{} joints are at zero", Values().size()));
    if (!puppet_.KeepCalibration())
      Say(fmt::format("{} stays as it is: it may be that of a real puppet",
                      flags_.puppet.calibration));
  }

  /// @throws QualityError  a joint has drifted
  void Verify() {
    Ask("put the puppet into its zero position again");
    RequireRest();
    std::string drifted;
    int off = 0;
    for (std::size_t j = 0; j < Values().size(); ++j) {
      const bool turns = Turns(j);
      const EditUnit unit = Unit(j);
      const double error = Values()[j] / unit.size;
      if (Counts(j) == 0) continue;
      ++off;
      Say(fmt::format("  {:20} {:+d} counts, {:+.3f} {}", Name(j), Counts(j), error, unit.name));
      // A slide's tolerance is that many counts which a joint's tolerance is.
      if (turns ? std::abs(error) > flags_.tolerance_deg : std::abs(Counts(j)) > kWiggleCounts)
        drifted += (drifted.empty() ? "" : ", ") + Name(j);
    }
    Say(fmt::format("{} of {} joints are not at zero", off, Values().size()));
    if (!drifted.empty())
      throw QualityError(
          fmt::format("drifted by more than {} degrees: {}; look after these "
                      "encoders' couplings, then calibrate again",
                      flags_.tolerance_deg, drifted));
  }

  /// @throws QualityError  a joint has not moved
  void Wiggle() {
    const std::string words =
        "move every joint to and fro; it ends by itself when all sensors have moved";
    if (flags_.page)
      Tell("ask", words);
    else
      Say(words);
    if (flags_.asks && !flags_.page) Say("press Enter to end it before");
    const std::vector<std::int64_t> begin = AllCounts();
    std::vector<bool> moved(begin.size());
    std::size_t left = begin.size();
    while (left > 0 && !input_.Next(0.01) && !input_.over()) {
      Poll();
      for (std::size_t j = 0; j < begin.size(); ++j)
        if (!moved[j] && std::abs(Counts(j) - begin[j]) >= kWiggleCounts) {
          moved[j] = true;
          Say(fmt::format("  {} moves, {} to go", Name(j), --left));
        }
    }
    if (left == 0) return;
    std::string still;
    for (std::size_t j = 0; j < begin.size(); ++j)
      if (!moved[j]) still += (still.empty() ? "" : ", ") + Name(j);
    throw QualityError("these sensors have not moved: " + still +
                       "; look after plugs and couplings");
  }

  /// Gears from the angles of a file.
  void FitGears() {
    for (const auto& [joint, values] : KnownAngles()) {
      std::vector<KnownAngle> known = {{0, 0}};
      for (const double value : values) {
        Ask(fmt::format("put {} to {:g} {}", Name(joint), value / Unit(joint).size,
                        Unit(joint).name));
        RequireRest();
        known.push_back({value, Values()[joint] * puppet_.reader().tracker().states()[joint].gear});
      }
      GearFit fit;
      try {
        fit = FitGear(known);
      } catch (const InputError& error) {
        throw InputError(fmt::format("{}: {}", Name(joint), error.what()));
      }
      puppet_.reader().SetGear(joint, fit.gear);
      Say(fmt::format("  {:20} gear {:.5f} of the description's, {:.3g} {} left", Name(joint),
                      fit.gear, fit.residual / Unit(joint).size, Unit(joint).name));
    }
    if (!flags_.written.empty()) WriteDescription();
  }

 private:
  const std::vector<double>& Values() { return puppet_.reader().last().values; }
  bool Turns(std::size_t j) {
    return puppet_.armature().nodes[static_cast<std::size_t>(puppet_.armature().joints[j])].kind ==
           NodeKind::kJoint;
  }
  EditUnit Unit(std::size_t j) { return EditUnitOf(puppet_.armature(), static_cast<int>(j)); }
  const std::string& Name(std::size_t j) { return puppet_.JointName(static_cast<int>(j)); }
  std::int64_t Counts(std::size_t j) { return puppet_.reader().tracker().states()[j].counts; }
  std::vector<std::int64_t> AllCounts() {
    std::vector<std::int64_t> counts;
    for (const SensorState& state : puppet_.reader().tracker().states())
      counts.push_back(state.counts);
    return counts;
  }

  /// Parts of an old calibration that are for another description.
  void TellFresh() {
    std::string names;
    for (const std::string& name : puppet_.fresh_joints())
      names += (names.empty() ? "" : ", ") + name;
    if (!names.empty()) Say("new in the description, or on another sensor than before: " + names);
  }

  void Poll() {
    if (WasInterrupted()) throw Cancelled();
    puppet_.Poll();
    Teller teller(flags_.page);
    for (const ReaderEvent& event : puppet_.reader().TakeEvents()) teller.Tell(event, puppet_);
  }

  void Pass(double seconds) {
    for (const double until = SteadySeconds() + seconds; SteadySeconds() < until;) {
      Poll();
      ::usleep(5000);
    }
  }

  /// A line for a person, or an event for a page.
  void Say(const std::string& words) {
    if (flags_.page) return Tell("said", words);
    fmt::print("{}\n", words);
    std::fflush(stdout);
  }
  static void Tell(const char* event, const std::string& words) {
    const auto first = words.find_first_not_of(' ');
    const nlohmann::json line = {{"event", event}, {"words", words.substr(first)}};
    fmt::print("{}\n", line.dump());
    std::fflush(stdout);
  }

  /// Says what to do, and waits for Enter.
  void Ask(const std::string& words) {
    if (flags_.page)
      Tell("ask", words);
    else
      Say(words + (flags_.asks ? ", then press Enter" : ""));
    if (!flags_.asks) return Pass(0.05);
    while (!input_.Next(0.01)) {
      if (input_.over()) throw UsageError("the input ended before Enter was pressed");
      Poll();
    }
  }

  /// Two readings that agree to a count, as against a mechanical stop.
  void RequireRest() {
    Pass(0.1);
    const std::vector<std::int64_t> first = AllCounts();
    Pass(kTwoReadings_s);
    if (!puppet_.reader().last().fresh)
      throw ToolError("the controller does not answer; calibrate when it does");
    for (std::size_t j = 0; j < first.size(); ++j)
      if (std::abs(Counts(j) - first[j]) > 1)
        throw InputError(
            fmt::format("{} moves: two readings differ by {} counts; fix the puppet "
                        "against its blocks and begin again",
                        Name(j), Counts(j) - first[j]));
  }

  /// Of each joint the values that it is put to: lines `JOINT DEGREES ...`, `#` for comments.
  std::vector<std::pair<std::size_t, std::vector<double>>> KnownAngles() {
    const std::string file = PrintableName(flags_.known);
    const std::vector<Word> words = SplitWords(ReadFile(flags_.known), file);
    WordReader reader(words, file);
    std::vector<std::pair<std::size_t, std::vector<double>>> known;
    while (!reader.AtEnd()) {
      const Word& word = reader.Peek();
      const std::string name = reader.Name("the name of a joint");
      std::size_t joint = 0;
      try {
        joint = puppet_.JointNamed(name);
      } catch (const UsageError& error) {
        reader.Fail(word, error.what());
      }
      known.push_back({joint, {}});
      while (!reader.AtEnd() && reader.Peek().line == word.line)
        known.back().second.push_back(reader.Number("an angle") * Unit(joint).size);
      if (known.back().second.empty()) reader.Fail(word, Quoted(name) + " has no angle behind it");
    }
    return known;
  }

  /// The description with the ratios that were found, all else as it was.
  void WriteDescription() {
    DescriptionFile file = DescriptionFile::Parse(ReadFile(flags_.puppet.description),
                                                  PrintableName(flags_.puppet.description));
    for (std::size_t j = 0; j < puppet_.armature().joints.size(); ++j) {
      const double gear = puppet_.reader().tracker().states()[j].gear;
      if (gear == 1) continue;
      const int node = puppet_.armature().joints[j];
      file.SetScale(node, puppet_.armature().nodes[static_cast<std::size_t>(node)].scale * gear);
      puppet_.reader().SetGear(j, 1);  // it is in the description now
    }
    WriteFileAtomically(flags_.written, file.Text());
    Say(fmt::format("written: {}; use it with this calibration from now on", flags_.written));
  }

  const CalibrateFlags& flags_;
  Puppet& puppet_;
  LineInput input_;
};

CalibrationUse UseOf(const CalibrateFlags& flags) {
  if (flags.wiggle) return CalibrationUse::kNotNeeded;
  const bool keeps = flags.verify || !flags.known.empty();
  return keeps ? CalibrationUse::kKept : CalibrationUse::kMade;
}

int Calibrate(const CalibrateFlags& flags) {
  Puppet puppet(flags.puppet, UseOf(flags));
  Calibrator calibrator(flags, puppet);
  if (flags.verify)
    calibrator.Verify();
  else if (flags.wiggle)
    calibrator.Wiggle();
  else if (!flags.known.empty())
    calibrator.FitGears();
  else
    calibrator.SetZero();
  puppet.SaveCalibration();
  return static_cast<int>(ExitCode::kOk);
}

}  // namespace

int CalibrateCommand(int argc, char** argv) {
  CLI::App app(
      "Sets a puppet's zero position, in which spine and legs are straight, and writes the "
      "calibration file.",
      "keypose armature calibrate");
  CalibrateFlags flags;
  AddPuppetFlags(app, flags.puppet);
  auto* verify = app.add_flag("--verify", flags.verify,
                              "in the zero position again: how far each joint has drifted");
  auto* wiggle = app.add_flag("--wiggle", flags.wiggle, "which sensors answer when joints move");
  app.add_option("--known", flags.known,
                 "file of known angles, lines `JOINT DEGREES ...`: fits the joints' gear ratios")
      ->excludes(verify)
      ->excludes(wiggle);
  app.add_option("--written", flags.written,
                 "with --known: the description with the ratios that were found");
  app.add_option("--tolerance", flags.tolerance_deg, "of --verify [deg]")->capture_default_str();
  app.add_flag("--keep-counters", flags.keeps_counters,
               "leave the controller's own counters as they are");
  app.add_flag("!--yes", flags.asks, "do not wait for Enter: the puppet stands as it should");
  app.add_flag("--page", flags.page, "tell all in lines of JSON, for the studio's page");
  verify->excludes(wiggle);
  return RunCommandLine(app, argc, argv, [&] { return Calibrate(flags); });
}

}  // namespace keypose::armature
