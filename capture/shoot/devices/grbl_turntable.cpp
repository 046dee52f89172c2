#include "capture/shoot/devices/grbl_turntable.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <sstream>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/line_port.h"

namespace keypose::capture::shoot {
namespace {

constexpr double kInch_mm = 25.4;
/// Places are told to a thousandth of an inch [inch].
constexpr double kInchGrain = 0.002;
constexpr const char* kSoftReset = "\x18";

/// The axis' value of "1.000,2.000,3.000".
bool ValueOf(const std::string& list, char axis, double* value) {
  std::istringstream in(list);
  std::string word;
  for (char name = 'X'; name <= axis; ++name)
    if (!std::getline(in, word, ',')) return false;
  char* end = nullptr;
  *value = std::strtod(word.c_str(), &end);
  return end != word.c_str() && std::isfinite(*value);
}

class GrblTurntable final : public TurntableDevice {
 public:
  GrblTurntable(const std::filesystem::path& device, const GrblOptions& options,
                const GrblTimes& times)
      : device_(device), options_(options), times_(times) {}

  void Connect(double angle_deg, bool turning, const std::string&, Patience& patience) override {
    port_.Open(device_);
    was_reset_ = false;
    WakeUp(patience);
    const GrblStatus status = Status(patience);
    // Only the controller that this object has set up can still know where it was going.
    const bool still_counts = set_up_ && !was_reset_ && status.state != "Alarm";
    if (turning && still_counts) return;
    if (status.state == "Alarm") Send("$X", patience);
    if (turning) Lost();
    SetUp(angle_deg, patience);
  }

  void TurnTo(double angle_deg, Patience& patience) override {
    GrblStatus status = Status(patience);
    if (was_reset_) {  // at rest: it stands where it stood
      SetUp(position_deg_, patience);
      status = Status(patience);
    }
    const double target_deg = NearestTurn(position_deg_, angle_deg);
    const Turn turn{Reported(status), (target_deg - position_deg_) / options_.degrees_per_unit,
                    target_deg / options_.degrees_per_unit,
                    std::abs(target_deg - position_deg_) / options_.speed_deg_s};
    char line[96];
    std::snprintf(line, sizeof line, "G90 G1 %c%.4f F%.2f", options_.axis,
                  target_deg / options_.degrees_per_unit,
                  60 * options_.speed_deg_s / options_.degrees_per_unit);
    for (int start = 0; start < times_.stalls; ++start) {
      Send(line, patience);
      if (Arrives(turn, patience)) {
        position_deg_ = target_deg;
        return;
      }
    }
    throw DeviceFault("table-stalled", "the turntable does not turn, although it says so",
                      "see whether something blocks it, and whether its motor has power", true);
  }

  void Declare(double angle_deg, Patience& patience) override { SetUp(angle_deg, patience); }
  double angle_deg() const override { return WithinTurn(position_deg_); }

 private:
  /// A turn that was sent.
  struct Turn {
    double began = 0;            ///< place that was reported before
    double way = 0, target = 0;  ///< [units]
    double least_s = 0;          ///< it cannot end earlier
  };

  [[noreturn]] void Lost() {
    set_up_ = false;
    throw PositionLost("table-lost",
                       "the turntable's controller was reset while it turned, so its angle is "
                       "unknown",
                       "turn it by hand to the angle that is asked for", true);
  }

  /// Waits for the greeting that follows the reset by the opening of the port, if there is one.
  void WakeUp(Patience& patience) {
    const double until = patience.Now() + times_.wake_up_s;
    port_.Write("\r\n\r\n");
    while (!was_reset_ && patience.Now() < until) {
      if (!Read(until - patience.Now(), patience)) break;
    }
  }

  /// A line, with a look for the greeting that tells of a reset.
  std::optional<std::string> Read(double timeout_s, Patience& patience) {
    auto line = port_.ReadLine(std::max(0.0, timeout_s), patience);
    if (line && line->starts_with("Grbl ")) {
      was_reset_ = true;
      alarmed_ = false;
    }
    if (line && line->starts_with("ALARM:")) alarmed_ = true;
    return line;
  }

  GrblStatus Status(Patience& patience) {
    for (int attempt = 0; attempt < times_.repeats; ++attempt) {
      port_.Write("?");
      const double until = patience.Now() + times_.reply_s / 4;
      while (patience.Now() < until) {
        const auto line = Read(until - patience.Now(), patience);
        if (!line) break;
        GrblStatus status;
        if (!ParseGrblStatus(*line, options_.axis, &status)) continue;
        if (inches_) InMillimetres(&status);
        if (status.has_offset) offset_ = status.offset;
        return status;
      }
      // After a limit switch GRBL takes nothing but a reset.
      if (alarmed_) port_.Write(kSoftReset);
    }
    throw DeviceFault("table-silent", "the turntable does not answer",
                      "see whether it has power, and whether " + device_.string() +
                          " is the port of its GRBL controller",
                      false);
  }

  static void InMillimetres(GrblStatus* status) {
    status->machine_position *= kInch_mm;
    status->work_position *= kInch_mm;
    status->offset *= kInch_mm;
  }

  /// Whether the controller reports places in inches ($13=1): lines are in millimetres all the
  /// same. Others do not list settings, and are found out by their first turn.
  void AskForUnits(Patience& patience) {
    port_.Drain();
    port_.Write("$$\n");
    const double until = patience.Now() + times_.reply_s / 4;
    while (patience.Now() < until) {
      const auto line = Read(until - patience.Now(), patience);
      if (!line || *line == "ok" || line->starts_with("error:")) return;
      if (line->starts_with("$13=")) inches_ = line->starts_with("$13=1");
    }
  }

  /// Whether a turn that ended elsewhere has ended in its place, told in inches.
  bool EndedInInches(const Turn& turn, const GrblStatus& status) const {
    const double off = std::abs((Reported(status) - turn.began) * kInch_mm - turn.way);
    return !inches_ && std::abs(turn.way) > 1 && off < kInchGrain * kInch_mm;
  }

  /// After a limit switch GRBL takes nothing but a reset, and has lost its place.
  [[noreturn]] void RecoverFromAlarm(Patience& patience) {
    port_.Write(kSoftReset);
    const double until = patience.Now() + times_.wake_up_s;
    while (alarmed_ && patience.Now() < until)
      if (!Read(until - patience.Now(), patience)) break;
    Lost();
  }

  /// Sends a line until it is acknowledged. All lines that are sent may be carried out twice.
  void Send(const std::string& line, Patience& patience) {
    for (int attempt = 0; attempt < times_.repeats; ++attempt) {
      port_.Drain();
      port_.Write(line + "\n");
      const double until = patience.Now() + times_.reply_s;
      while (patience.Now() < until) {
        const auto answer = Read(until - patience.Now(), patience);
        if (!answer) break;
        if (*answer == "ok") return;
        if (answer->starts_with("ALARM:")) RecoverFromAlarm(patience);
        if (answer->starts_with("error:")) {
          // What is left of a damaged line is refused too; only a line that stays refused is wrong.
          if (attempt + 1 == times_.repeats) Refused(line, *answer);
          if (*answer == "error:9") port_.Write("$X\n");
          break;
        }
      }
    }
    throw DeviceFault("table-silent", "the turntable does not acknowledge '" + line + "'",
                      "see whether it has power", false);
  }

  [[noreturn]] void Refused(const std::string& line, const std::string& reason) {
    throw DeviceFault("table-refused", "GRBL answers '" + line + "' with '" + reason + "'",
                      "look the number up in GRBL's documentation, and see its settings ($$)",
                      true);
  }

  /// Units per minute, absolute coordinates, and the present place as the given angle.
  void SetUp(double angle_deg, Patience& patience) {
    was_reset_ = false;
    position_deg_ = WithinTurn(angle_deg);
    if (Status(patience).state == "Alarm") Send("$X", patience);
    AskForUnits(patience);
    Send("G21 G90 G94", patience);
    char line[64];
    std::snprintf(line, sizeof line, "G92 %c%.4f", options_.axis,
                  position_deg_ / options_.degrees_per_unit);
    Send(line, patience);
    offset_ = MachinePosition(patience) - position_deg_ / options_.degrees_per_unit;
    if (was_reset_) Lost();
    set_up_ = true;
  }

  double MachinePosition(Patience& patience) {
    const GrblStatus status = Status(patience);
    return status.has_machine_position ? status.machine_position : status.work_position + offset_;
  }

  static double Reported(const GrblStatus& status) {
    return status.has_machine_position ? status.machine_position : status.work_position;
  }

  double WorkPosition(const GrblStatus& status) const {
    return status.has_work_position ? status.work_position : status.machine_position - offset_;
  }

  /// Waits until the table stands at the turn's target; false if it stalls, or stopped elsewhere
  /// because the line was lost.
  bool Arrives(const Turn& turn, Patience& patience) {
    const double close =
        std::max(0.02 / options_.degrees_per_unit, inches_ ? kInchGrain * kInch_mm : 0.0);
    // Right after `ok` the controller may be idle for a moment, and may even tell the place where
    // it will be.
    constexpr double kGrace_s = 0.5;
    const double sent = patience.Now();
    double last = INFINITY, moved = sent;
    while (true) {
      const GrblStatus status = Status(patience);
      if (was_reset_) Lost();
      if (status.state.starts_with("Alarm")) {
        Send("$X", patience);
        Lost();
      }
      if (status.state.starts_with("Hold") || status.state.starts_with("Door")) port_.Write("~");
      const double place = WorkPosition(status), passed_s = patience.Now() - sent;
      const bool there = std::abs(place - turn.target) < close;
      if (status.state == "Idle" && there && passed_s >= turn.least_s) return true;
      if (status.state == "Idle" && !there && passed_s > std::max(kGrace_s, turn.least_s)) {
        if (!EndedInInches(turn, status)) return false;
        inches_ = true;
        offset_ = status.machine_position * kInch_mm - turn.target;
        return true;
      }
      if (std::abs(place - last) > 1e-9 || status.state == "Idle") moved = patience.Now();
      if (patience.Now() - moved > times_.stall_s) {
        port_.Write("!");  // hold, then go on: starts a motor that has lost its step
        patience.Wait(times_.ask_s);
        port_.Write("~");
        return false;
      }
      last = place;
      patience.Wait(times_.ask_s);
    }
  }

  std::filesystem::path device_;
  GrblOptions options_;
  GrblTimes times_;
  LinePort port_;
  bool was_reset_ = false, set_up_ = false;
  bool alarmed_ = false;  ///< since its last greeting
  bool inches_ = false;   ///< it tells places in inches
  double position_deg_ = 0;
  double offset_ = 0;  ///< machine minus work position [units]
};

}  // namespace

bool ParseGrblStatus(const std::string& line, char axis, GrblStatus* status) {
  const std::size_t begin = line.rfind('<'), end = line.rfind('>');
  if (begin == std::string::npos || end == std::string::npos || end < begin + 2) return false;
  std::istringstream fields(line.substr(begin + 1, end - begin - 1));
  std::string field;
  std::getline(fields, status->state, '|');
  status->state = status->state.substr(0, status->state.find(':'));  // "Hold:0"
  while (std::getline(fields, field, '|')) {
    if (field.starts_with("MPos:"))
      status->has_machine_position = ValueOf(field.substr(5), axis, &status->machine_position);
    if (field.starts_with("WPos:"))
      status->has_work_position = ValueOf(field.substr(5), axis, &status->work_position);
    if (field.starts_with("WCO:"))
      status->has_offset = ValueOf(field.substr(4), axis, &status->offset);
  }
  return status->has_machine_position || status->has_work_position;
}

std::unique_ptr<TurntableDevice> MakeGrblTurntable(const std::filesystem::path& device,
                                                   const GrblOptions& options,
                                                   const GrblTimes& times) {
  return std::make_unique<GrblTurntable>(device, options, times);
}

}  // namespace keypose::capture::shoot
