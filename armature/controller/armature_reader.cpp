#include "armature/controller/armature_reader.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

#include "armature/controller/steady_clock.h"
#include "core/io/text/serial_port.h"
#include "core/values/errors.h"

namespace keypose::armature {
namespace {

/// Some flags stay until their counter is reset; they need not be asked for with each reading.
constexpr double kFlagsEvery_s = 0.5;

std::string AdviceFor(int error, const std::string& device) {
  if (error == EACCES)
    return "type `sudo usermod -aG dialout $USER`, log out and in again, and start once more";
  if (error == EBUSY) return "end the other program that uses " + device;
  if (error == ENOTTY)
    return "it is no serial port; name the controller's as --port; " + KnownPorts();
  return "plug in the controller's cable, and give its name as --port; " + KnownPorts();
}

bool Contains(const std::vector<int>& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

}  // namespace

class ArmatureReader::Port final : public ByteLine {
 public:
  /// @return whether the board begins again by that
  bool Open(const PortOptions& options) {
    port_.Open(options.device, options.baud);
    return port_.has_raised_dtr();
  }
  void Write(std::string_view bytes) override { port_.Write(bytes); }
  std::string Read(double timeout_s) override { return port_.Read(timeout_s); }

 private:
  SerialPort port_;
};

ArmatureReader::ArmatureReader(const Armature& armature, const PortOptions& port,
                               const Calibration& calibration)
    : armature_(armature),
      options_(port),
      tracker_(armature, calibration.sensors),
      boot_(calibration.boot) {
  try {
    while (!Connect()) ::usleep(10000);
  } catch (const PortFault& fault) {
    throw ToolError(
        fmt::format("armature: {}; {}", fault.what(), AdviceFor(fault.error, port.device)));
  } catch (const BoxFault& fault) {
    throw ToolError(
        fmt::format("armature: {} on {}; is it another device's port, or another speed "
                    "than {} baud?",
                    fault.what(), port.device, port.baud));
  }
  reading_.values = tracker_.values();  // also if its first reading fails
  Poll();
}

ArmatureReader::~ArmatureReader() = default;

void ArmatureReader::Say(const std::string& code, const std::string& words,
                         const std::string& what_to_do, int joint) {
  events_.push_back({code, words, what_to_do, joint});
}

std::vector<ReaderEvent> ArmatureReader::TakeEvents() { return std::exchange(events_, {}); }

/// @return false: its port is open, but the board is still starting
bool ArmatureReader::Connect() {
  if (!opened_) {
    if (link_) {
      repeats_ += link_->repeats();
      damaged_ += link_->damaged();
    }
    link_.reset();
    port_ = std::make_unique<Port>();
    const bool starts = port_->Open(options_);
    opened_ = true;
    // A board that fell silent may be starting, by its reset button: its boot loader waits on as
    // long as something comes.
    greet_s_ = SteadySeconds() + (starts || was_silent_ ? options_.start_s : 0);
  }
  if (SteadySeconds() < greet_s_) return false;
  link_ = std::make_unique<BoxLink>(*port_, options_.link);
  Begin();
  away_ = was_silent_ = false;
  return true;
}

void ArmatureReader::Begin() {
  const BoxInfo& box = link_->Greet();
  const bool same = box.boot == boot_;
  tracker_.Begin(box, same);
  if (!same && boot_ >= 0) ForgetLostPower();
  if (!same && boot_ >= 0)
    Say("power-lost",
        "the controller was without power: its counters began anew, and what was moved meanwhile "
        "is "
        "not known",
        "compare the puppet with the last recorded frame; if it was touched, set it into its zero "
        "position and calibrate");
  boot_ = box.boot;
  // After a power-up all counters have lost their counts, which is said once, not for each.
  told_flags_.assign(static_cast<std::size_t>(box.sensors), same ? 0 : kFlagLostCount);
  next_flags_s_ = 0;
}

/// A counter keeps the flag of the power that it lost until it is set. Once all are said to have
/// lost theirs, a flag shall mean that one of them has lost its own since.
void ArmatureReader::ForgetLostPower() {
  if (!link_->Update()) throw BoxFault("the controller starts again and again");
  if (!link_->alarm()) return;
  const std::vector<unsigned> flags = link_->ReadFlags();
  std::vector<std::pair<int, std::int32_t>> counts;
  for (std::size_t s = 0; s < flags.size(); ++s)
    if (flags[s] & kFlagLostCount) counts.emplace_back(static_cast<int>(s), link_->counts()[s]);
  link_->Preload(counts);
}

bool ArmatureReader::HasLostCount(int joint) const {
  const int node = armature_.joints[static_cast<std::size_t>(joint)];
  const auto sensor =
      static_cast<std::size_t>(armature_.nodes[static_cast<std::size_t>(node)].sensor);
  return sensor < told_flags_.size() && (told_flags_[sensor] & kFlagLostCount) != 0;
}

/// Sets the counter to what it shows, which ends its flag. Where that fails, the flag is told
/// again.
void ArmatureReader::EndLostCount(std::size_t joint) {
  if (away_) return;
  const int node = armature_.joints[joint];
  const int sensor = armature_.nodes[static_cast<std::size_t>(node)].sensor;
  try {
    link_->Preload({{sensor, link_->counts()[static_cast<std::size_t>(sensor)]}});
    told_flags_[static_cast<std::size_t>(sensor)] &= ~kFlagLostCount;
  } catch (const BoxFault&) {
  } catch (const PortFault&) {
  }
}

void ArmatureReader::Lose(const std::string& code, const std::string& words,
                          const std::string& what_to_do) {
  if (!away_) Say(code, words, what_to_do);
  away_ = true;
  opened_ = false;
  was_silent_ = code == "silent";
  next_try_s_ = SteadySeconds() + options_.retry_s;
}

const Reading& ArmatureReader::Poll() {
  reading_.fresh = false;
  reading_.changed.clear();
  double asked_s = reading_.time_s = SteadySeconds();
  try {
    if (away_) {
      if (reading_.time_s < next_try_s_) return reading_;
      const auto told = static_cast<std::ptrdiff_t>(events_.size());
      if (!Connect()) return reading_;
      // What it has lost meanwhile is told after that: a page shows the last word.
      events_.insert(events_.begin() + told,
                     {"cable-back", "the controller answers again", "", -1});
    }
    if (!link_->Update()) {
      Begin();
      asked_s = SteadySeconds();
      if (!link_->Update()) throw BoxFault("the controller starts again and again");
    }
  } catch (const PortFault& fault) {
    Lose("cable-out", fault.what(), "plug it in again; it goes on by itself");
    return reading_;
  } catch (const BoxFault& fault) {
    Lose("silent", fault.what(), "look after the controller's power; it goes on by itself");
    return reading_;
  }
  reading_.time_s = SteadySeconds();
  tracker_.Take(link_->counts(), asked_s, reading_.time_s);
  reading_.fresh = true;
  reading_.held = tracker_.held();
  for (std::size_t j = 0; j < armature_.joints.size(); ++j)
    if (reading_.values[j] != tracker_.values()[j]) reading_.changed.push_back(static_cast<int>(j));
  reading_.values = tracker_.values();
  TellHeld();
  TellFlags();
  return reading_;
}

void ArmatureReader::TellHeld() {
  for (const int joint : reading_.held)
    if (!Contains(told_held_, joint)) {
      const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[joint])];
      Say("sensor-jumped",
          fmt::format("sensor {} ({}) jumped farther than a shaft can turn; its last good value is "
                      "held",
                      node.sensor, node.name),
          "look after its plug and cable if it does not come back", joint);
    }
  // One that lost its count is not as it was, though its counter goes on.
  for (const int joint : told_held_)
    if (!Contains(reading_.held, joint) && !HasLostCount(joint))
      Say("sensor-back",
          fmt::format("{} is read again",
                      armature_.nodes[static_cast<std::size_t>(armature_.joints[joint])].name),
          "", joint);
  told_held_ = reading_.held;
}

void ArmatureReader::TellFlags() {
  if (!link_->alarm()) {
    std::fill(told_flags_.begin(), told_flags_.end(), 0u);
    return;
  }
  // A counter that jumps may just have lost its count.
  if (reading_.time_s < next_flags_s_ && reading_.held.empty()) return;
  next_flags_s_ = reading_.time_s + kFlagsEvery_s;
  std::vector<unsigned> flags;
  try {
    flags = link_->ReadFlags();
  } catch (const BoxFault&) {
    return;  // the next reading asks again
  } catch (const PortFault&) {
    return;
  }
  for (std::size_t j = 0; j < armature_.joints.size(); ++j) {
    const ArmatureNode& node = armature_.nodes[static_cast<std::size_t>(armature_.joints[j])];
    const auto sensor = static_cast<std::size_t>(node.sensor);
    const unsigned fresh = flags[sensor] & ~told_flags_[sensor];
    if (fresh & kFlagLostCount) {
      if (Contains(reading_.held, static_cast<int>(j))) tracker_.CountsFromZero(j);
      Say("sensor-lost-count",
          fmt::format("the counter of sensor {} ({}) lost power and its count", node.sensor,
                      node.name),
          "look after its card; then set this joint to a known angle", static_cast<int>(j));
    }
    if (fresh & kFlagNoSignal)
      Say("sensor-no-signal", fmt::format("sensor {} ({}) gives no signal", node.sensor, node.name),
          "look after its plug and cable; then set this joint to a known angle",
          static_cast<int>(j));
  }
  told_flags_ = flags;
}

Calibration ArmatureReader::calibration() const { return {boot_, tracker_.states()}; }

const BoxInfo& ArmatureReader::box() const { return link_->info(); }

void ArmatureReader::SetValue(std::size_t joint, double value) {
  if (HasLostCount(static_cast<int>(joint))) EndLostCount(joint);
  tracker_.SetValue(joint, value);
  reading_.values[joint] = tracker_.values()[joint];
}

void ArmatureReader::SetGear(std::size_t joint, double gear) {
  tracker_.SetGear(joint, gear);
  reading_.values[joint] = tracker_.values()[joint];
}

void ArmatureReader::ResetCounters() {
  try {
    link_->Reset(-1);
    for (std::size_t j = 0; j < armature_.joints.size(); ++j) tracker_.SetValue(j, 0);
    tracker_.Begin(link_->info(), false);
  } catch (const PortFault& fault) {
    throw ToolError(
        fmt::format("armature: {}; the counters are not reset: begin again", fault.what()));
  } catch (const BoxFault& fault) {
    throw ToolError(
        fmt::format("armature: {}; the counters are not reset: begin again", fault.what()));
  }
}

int ArmatureReader::repeats() const { return repeats_ + (link_ ? link_->repeats() : 0); }
int ArmatureReader::damaged() const { return damaged_ + (link_ ? link_->damaged() : 0); }

}  // namespace keypose::armature
