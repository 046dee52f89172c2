#include "armature/puppet.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "armature/controller/steady_clock.h"
#include "armature/description/description_file.h"
#include "armature/recording/curve_edits.h"
#include "core/io/text/files.h"
#include "core/io/text/serial_port.h"
#include "core/values/errors.h"

namespace keypose::armature {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr double kRest_s = 0.1, kSaveEvery_s = 1;
/// A puppet that has not come to rest for so long, while a frame waits for it, is told of.
constexpr double kPatience_s = 3;

Calibration LoadCalibration(const PuppetFlags& flags, const Armature& armature, CalibrationUse use,
                            std::vector<std::string>* fresh) {
  if (use == CalibrationUse::kNotNeeded) return {};
  const bool makes = use == CalibrationUse::kMade, there = fs::exists(flags.calibration);
  if (!there && makes) return {};
  if (!there)
    throw DiskError(
        fmt::format("there is no calibration {}; make it with `keypose armature "
                    "calibrate --description {} --port {} --calibration {}`",
                    flags.calibration, flags.description, flags.port, flags.calibration));
  const std::string text = ReadFile(flags.calibration), name = PrintableName(flags.calibration);
  return makes ? FittingCalibration(text, name, armature, fresh)
               : ParseCalibration(text, name, armature);
}

}  // namespace

void AddPuppetFlags(CLI::App& app, PuppetFlags& flags) {
  app.add_option("--description", flags.description, "the armature's description file")->required();
  app.add_option("--port", flags.port,
                 "the controller's serial port, such as /dev/ttyACM0; simulated: a puppet without "
                 "hardware")
      ->required();
  app.add_option("--baud", flags.baud, "the port's speed")->capture_default_str();
  app.add_option("--calibration", flags.calibration,
                 "file of zero position and counts, kept up to date (.json)");
  app.add_option("--faults", flags.faults,
                 "of a simulated puppet, such as drop@5,stuck:leftKneeBend@20: at frames 5 and 20");
}

Armature LoadArmature(const fs::path& description) {
  return DescriptionFile::Parse(ReadFile(description), PrintableName(description)).armature();
}

int RunCommandLine(CLI::App& app, int argc, char** argv, const std::function<int()>& run) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    fmt::print("{}", app.help());
    return static_cast<int>(ExitCode::kOk);
  } catch (const CLI::ParseError& error) {
    throw UsageError(fmt::format("{}; see `{} --help`", error.what(), app.get_name()));
  }
  CatchInterrupts();
  return run();
}

Puppet::Puppet(const PuppetFlags& flags, CalibrationUse use)
    : flags_(flags),
      armature_(LoadArmature(flags.description)),
      keeps_(use == CalibrationUse::kKept && flags.port != "simulated") {
  const bool simulates = flags.port == "simulated";
  if (!IsBaudRate(flags.baud))
    throw UsageError(fmt::format("--baud {}: no serial port has this speed", flags.baud));
  if (!simulates && !flags.faults.empty()) throw UsageError("--faults needs --port simulated");
  if (!simulates && flags.calibration.empty() && use != CalibrationUse::kNotNeeded)
    throw UsageError("--calibration is missing: the file that `keypose armature calibrate` makes");
  PortOptions port;
  port.device = flags.port;
  port.baud = flags.baud;
  if (simulates) {
    SimulationOptions options;
    options.faults = ParseFaults(flags.faults, armature_);
    port.device = fs::temp_directory_path() / fmt::format("keypose-puppet-{}", ::getpid());
    simulated_ = std::make_unique<SimulatedBox>(armature_, port.device, options);
  }
  // A simulated puppet begins anew in its zero position; the file is a real one's.
  const Calibration kept =
      simulates ? Calibration{} : LoadCalibration(flags, armature_, use, &fresh_);
  reader_ = std::make_unique<ArmatureReader>(armature_, port, kept);
  if (simulates)
    for (std::size_t j = 0; j < armature_.joints.size(); ++j) reader_->SetValue(j, 0);
  NoteRest(reader_->last());
}

Puppet::~Puppet() = default;

const Reading& Puppet::Poll() {
  const Reading& reading = reader_->Poll();
  NoteRest(reading);
  if (now_s_ - saved_s_ > kSaveEvery_s) SaveCalibration();
  return reading;
}

void Puppet::NoteRest(const Reading& reading) {
  now_s_ = reading.time_s;
  if (!reading.fresh) {
    rest_values_.clear();
    return;
  }
  bool moved = rest_values_.empty();
  for (std::size_t j = 0; !moved && j < rest_values_.size(); ++j) {
    moved = std::abs(reading.values[j] - rest_values_[j]) >
            1.5 * std::abs(reader_->tracker().StepOf(j));
    if (moved) moved_last_ = j;
  }
  if (!moved) return;
  rest_values_ = reading.values;
  rest_since_s_ = now_s_;
}

bool Puppet::at_rest() const { return !rest_values_.empty() && now_s_ - rest_since_s_ > kRest_s; }

const std::string& Puppet::JointName(int joint) const {
  const int node = armature_.joints[static_cast<std::size_t>(joint)];
  return armature_.nodes[static_cast<std::size_t>(node)].name;
}

std::size_t Puppet::JointNamed(const std::string& name) const {
  const int node = armature_.Find(name);
  const int joint = node < 0 ? -1 : armature_.JointOf(node);
  if (joint >= 0) return static_cast<std::size_t>(joint);
  std::vector<std::string> names;
  for (std::size_t j = 0; j < armature_.joints.size(); ++j)
    names.push_back(JointName(static_cast<int>(j)));
  throw UsageError(
      fmt::format("the armature has no joint {}{}", Quoted(name), DidYouMean(name, names)));
}

std::string Puppet::Obstacle(const Reading& reading, bool moving_too) {
  if (now_s_ - std::exchange(waited_s_, now_s_) > 0.5) waits_since_s_ = now_s_;
  if (!reading.fresh) return "the controller does not answer";
  if (!reading.held.empty())
    return "the sensor of " + JointName(reading.held.front()) + " is not read rightly";
  const bool turning = simulated_ && !simulated_->at_rest();
  if (moving_too || (!turning && at_rest())) {
    waited_s_ = -1;  // the next frame waits anew
    return "";
  }
  if (turning || now_s_ - waits_since_s_ < kPatience_s) return kPuppetMoves;
  return JointName(static_cast<int>(moved_last_)) + " does not come to rest";
}

void Puppet::SetJoint(const std::string& name, double number) {
  const std::size_t joint = JointNamed(name);
  reader_->SetValue(joint, number * EditUnitOf(armature_, static_cast<int>(joint)).size);
  SaveCalibration();
}

bool Puppet::KeepCalibration() {
  keeps_ = !simulated_ || !fs::exists(flags_.calibration);
  return keeps_;
}

void Puppet::SaveCalibration() {
  saved_s_ = now_s_;
  if (!keeps_ || flags_.calibration.empty()) return;
  const std::string text = CalibrationText(armature_, reader_->calibration());
  if (text == saved_) return;
  WriteFileAtomically(flags_.calibration, text);
  saved_ = text;
}

void Teller::Tell(const std::string& event, const std::string& words, const std::string& fields) {
  if (!json_) {
    fmt::print("{}\n", words);
  } else {
    json line = fields.empty() ? json::object() : json::parse(fields);
    line["event"] = event;
    line["words"] = words;
    fmt::print("{}\n", line.dump(-1, ' ', false, json::error_handler_t::replace));
  }
  std::fflush(stdout);
}

void Teller::Tell(const ReaderEvent& event, const Puppet& puppet) {
  json fields = {{"do", event.what_to_do}};
  if (event.joint >= 0) fields["joint"] = puppet.JointName(event.joint);
  const bool both = !json_ && !event.what_to_do.empty();
  Tell(event.code, event.words + (both ? "; " + event.what_to_do : ""), fields.dump());
}

}  // namespace keypose::armature
