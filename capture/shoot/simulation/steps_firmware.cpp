// The table's end of the protocol `steps:`, by docs/shoot.md.
#include <charconv>
#include <cmath>
#include <optional>

#include "capture/shoot/devices/steps_lines.h"
#include "capture/shoot/simulation/firmware.h"

namespace keypose::capture::shoot {
namespace {

class StepsFirmware final : public Protocol {
 public:
  explicit StepsFirmware(int steps_a_turn) : steps_a_turn_(steps_a_turn) {}

  std::string Reset(int boot) override {
    boot_ = boot;
    arrived_.clear();
    last_.reset();
    zero_deg_ = 0;
    return "";
  }

  std::string Receive(const std::string& bytes, SimulatedMotor& motor) override {
    arrived_ += bytes;
    std::string replies;
    for (std::size_t end; (end = arrived_.find('\n')) != std::string::npos;) {
      const auto line = ParseStepsLine('>', arrived_.substr(0, end));
      arrived_.erase(0, end + 1);
      if (!line) continue;
      const bool repeated = last_ && last_->sequence == line->sequence && last_->text == line->text;
      if (!repeated) last_reply_ = Carry(line->text, motor);
      last_ = line;
      replies += FormatStepsLine('<', {line->sequence, last_reply_}) + "\n";
    }
    return replies;
  }

 private:
  long At(const SimulatedMotor& motor) const {
    return std::lround((motor.counted_deg - zero_deg_) * steps_a_turn_ / 360);
  }

  std::string Place(const SimulatedMotor& motor) const {
    return "at=" + std::to_string(At(motor)) + " moving=" + (motor.moving() ? "1" : "0");
  }

  std::string Carry(const std::string& text, SimulatedMotor& motor) {
    const std::string word = text.substr(0, text.find(' '));
    const std::string boot = "boot=" + std::to_string(boot_) + " ";
    if (word == "HELLO")
      return "OK keypose=1 " + boot + "turn=" + std::to_string(steps_a_turn_) + " " + Place(motor);
    if (word == "AT") return "OK " + boot + Place(motor);
    if (word == "STOP") {
      motor.target_deg = motor.counted_deg;
      motor.stalled = false;
      return "OK " + Place(motor);
    }
    if (word != "GO" && word != "SET") return "ERR unknown";
    const std::string number = text.size() > word.size() ? text.substr(word.size() + 1) : "";
    long steps = 0;
    const char* const end = number.data() + number.size();
    if (std::from_chars(number.data(), end, steps).ptr != end || number.empty())
      return "ERR number";
    if (word == "SET") {
      if (motor.moving()) return "ERR moving";
      zero_deg_ = motor.counted_deg - 360.0 * static_cast<double>(steps) / steps_a_turn_;
      return "OK " + Place(motor);
    }
    motor.target_deg = zero_deg_ + 360.0 * static_cast<double>(steps) / steps_a_turn_;
    ++moves;
    return "OK at=" + std::to_string(At(motor)) + " moving=1";
  }

  int steps_a_turn_, boot_ = 0;
  double zero_deg_ = 0;
  std::string arrived_, last_reply_;
  std::optional<StepsLine> last_;
};

}  // namespace

std::unique_ptr<Protocol> MakeStepsFirmware(int steps_a_turn) {
  return std::make_unique<StepsFirmware>(steps_a_turn);
}

}  // namespace keypose::capture::shoot
