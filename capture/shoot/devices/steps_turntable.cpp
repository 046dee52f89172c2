#include "capture/shoot/devices/steps_turntable.h"

#include <cmath>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/line_port.h"
#include "capture/shoot/devices/steps_lines.h"

namespace keypose::capture::shoot {
namespace {

using Values = std::map<std::string, std::int64_t>;

class StepsTurntable final : public TurntableDevice {
 public:
  StepsTurntable(const std::filesystem::path& device, const StepsTimes& times)
      : device_(device), times_(times) {}

  void Connect(double angle_deg, bool turning, const std::string& memory,
               Patience& patience) override {
    port_.Open(device_);
    const std::string known_boot = boot_ >= 0 ? Memory() : memory;
    const Values hello = Hello(patience);
    if (!hello.contains("boot") || !hello.contains("turn") || hello.at("turn") < 1)
      Refused("HELLO", "no numbers");
    boot_ = hello.at("boot");
    steps_a_turn_ = hello.at("turn");
    const bool same = !known_boot.empty() && known_boot == Memory();
    if (same && turning) {
      // It kept its position and may still turn: the next TurnTo goes on from where it is.
      position_steps_ = At(patience).at;
      return;
    }
    if (turning)
      throw PositionLost("table-lost",
                         "the turntable was reset while it turned, so its angle is unknown",
                         "turn it by hand to the angle that is asked for", true);
    Stop(patience);
    Declare(angle_deg, patience);
  }

  void TurnTo(double angle_deg, Patience& patience) override {
    SetAgainAfterReset(patience);
    const auto target =
        std::llround(NearestTurn(angle_deg_of(position_steps_), angle_deg) * steps_a_turn_ / 360.0);
    for (int start = 0; start < times_.stalls; ++start) {
      Ask("GO " + std::to_string(target), patience);
      if (Arrives(target, patience)) {
        position_steps_ = target;
        return;
      }
      Stop(patience);
    }
    throw DeviceFault("table-stalled", "the turntable does not turn, although it says so",
                      "see whether something blocks it, and whether its motor has power", true);
  }

  void Declare(double angle_deg, Patience& patience) override {
    position_steps_ = std::llround(WithinTurn(angle_deg) * steps_a_turn_ / 360.0);
    Ask("SET " + std::to_string(position_steps_), patience);
    boot_ = At(patience).boot;
  }

  double angle_deg() const override { return WithinTurn(angle_deg_of(position_steps_)); }
  std::string Memory() const override { return "boot=" + std::to_string(boot_); }

 private:
  struct Place {
    std::int64_t at = 0, boot = 0;
    bool moving = false;
  };

  double angle_deg_of(std::int64_t steps) const {
    return 360.0 * static_cast<double>(steps) / static_cast<double>(steps_a_turn_);
  }

  [[noreturn]] void Refused(const std::string& line, const std::string& reason) {
    throw DeviceFault("table-refused", "the turntable answers '" + line + "' with '" + reason + "'",
                      "see whether its program speaks the protocol of docs/shoot.md", true);
  }

  /// A microcontroller that was reset by the opening of the port is deaf for a second.
  Values Hello(Patience& patience) {
    const double until = patience.Now() + times_.wake_up_s;
    while (true) {
      try {
        return Ask("HELLO", patience);
      } catch (const DeviceFault& fault) {
        if (fault.code != "table-silent" || patience.Now() > until) throw;
      }
    }
  }

  /// Sends a line until it is answered.
  Values Ask(const std::string& text, Patience& patience) {
    sequence_ = (sequence_ + 1) % 256;
    const std::string line = FormatStepsLine('>', {sequence_, text}) + "\n";
    for (int attempt = 0; attempt < times_.repeats; ++attempt) {
      port_.Write(line);
      const double until = patience.Now() + times_.reply_s;
      while (const double left = std::max(0.0, until - patience.Now())) {
        const auto answer = port_.ReadLine(left, patience);
        if (!answer) break;
        const auto reply = ParseStepsLine('<', *answer);
        if (!reply || reply->sequence != sequence_) continue;  // damaged, or of an older line
        if (reply->text.starts_with("OK")) return StepsValues(reply->text);
        Refused(text, reply->text);
      }
    }
    throw DeviceFault("table-silent", "the turntable does not answer",
                      "see whether it has power, and whether " + device_.string() + " is its port",
                      false);
  }

  Place At(Patience& patience) {
    const Values values = Ask("AT", patience);
    for (const char* key : {"at", "moving", "boot"})
      if (!values.contains(key)) Refused("AT", std::string("no ") + key);
    return {values.at("at"), values.at("boot"), values.at("moving") != 0};
  }

  /// @throws DeviceFault  it still turns after STOP
  void Stop(Patience& patience) {
    Ask("STOP", patience);
    const double until = patience.Now() + times_.stall_s;
    while (At(patience).moving) {
      if (patience.Now() > until) Refused("STOP", "moving=1");
      patience.Wait(times_.ask_s);
    }
  }

  /// A table that was reset at rest counts from 0, but stands where it stood.
  void SetAgainAfterReset(Patience& patience) {
    const Place place = At(patience);
    if (place.boot == boot_) return;
    boot_ = place.boot;
    Ask("SET " + std::to_string(position_steps_), patience);
  }

  /// Waits until the table stands at `target`; false if it stalls or stands elsewhere.
  bool Arrives(std::int64_t target, Patience& patience) {
    Place last = At(patience);
    double stepped = patience.Now();
    while (true) {
      const Place place = At(patience);
      if (place.boot != boot_) {
        boot_ = -1;
        throw PositionLost("table-lost",
                           "the turntable was reset while it turned, so its angle is unknown",
                           "turn it by hand to the angle that is asked for", true);
      }
      if (!place.moving) return place.at == target;
      if (place.at != last.at) stepped = patience.Now();
      if (patience.Now() - stepped > times_.stall_s) return false;
      last = place;
      patience.Wait(times_.ask_s);
    }
  }

  std::filesystem::path device_;
  StepsTimes times_;
  LinePort port_;
  int sequence_ = 0;
  std::int64_t boot_ = -1, steps_a_turn_ = 1, position_steps_ = 0;
};

}  // namespace

std::unique_ptr<TurntableDevice> MakeStepsTurntable(const std::filesystem::path& device,
                                                    const StepsTimes& times) {
  return std::make_unique<StepsTurntable>(device, times);
}

}  // namespace keypose::capture::shoot
