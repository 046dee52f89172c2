// What a GRBL 1.1 controller answers, as far as a turntable needs it.
// Source: the GRBL wiki, "Grbl v1.1 Interface".
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <regex>
#include <utility>

#include "capture/shoot/simulation/firmware.h"

namespace keypose::capture::shoot {
namespace {

constexpr double kInch_mm = 25.4;
constexpr char kSoftReset = '\x18';

class GrblFirmware final : public Protocol {
 public:
  explicit GrblFirmware(const GrblHabits& habits) : habits_(habits) {}

  std::string Reset(int) override {
    offset_ = 0;
    absolute_ = true;
    held_ = alarm_ = deaf_ = false;
    line_.clear();
    reports_ = 0;
    return "\r\nGrbl 1.1h ['$' for help]\r\n";
  }

  std::string Receive(const std::string& bytes, SimulatedMotor& motor) override {
    std::string replies;
    for (const char c : bytes) {
      if (c == kSoftReset) {
        motor.target_deg = motor.counted_deg;
        replies += Reset(0);
      }
      if (deaf_ || c == kSoftReset) continue;
      if (c == '?') replies += Status(motor);
      if (c == '!') held_ = motor.moving();
      if (c == '~') held_ = motor.stalled = false;
      if (c == '?' || c == '!' || c == '~' || c == '\r') continue;
      if (c != '\n') {
        line_ += c;
        continue;
      }
      replies += Carry(std::exchange(line_, ""), motor);
    }
    return replies;
  }

 private:
  std::string Status(const SimulatedMotor& motor) {
    const bool early = early_idle_ > 0;
    early_idle_ -= early;
    const double place = early ? motor.target_deg : motor.counted_deg,
                 unit = habits_.inches ? kInch_mm : 1;
    const char* state = motor.moving() && !early ? "Run" : "Idle";
    if (held_) state = "Hold:0";
    if (alarm_) state = "Alarm";
    char text[128];
    std::snprintf(text, sizeof text, "<%s|MPos:%.3f,0.000,0.000|FS:0,0", state, place / unit);
    std::string report = text;
    if (reports_++ % 10 == 0) {
      std::snprintf(text, sizeof text, "|WCO:%.3f,0.000,0.000", offset_ / unit);
      report += text;
    }
    return report + ">\r\n";
  }

  std::string Carry(const std::string& line, SimulatedMotor& motor) {
    if (line == "$X") {
      alarm_ = false;
      return "[MSG:Caution: Unlocked]\r\nok\r\n";
    }
    if (line.empty()) return "ok\r\n";
    if (alarm_) return "error:9\r\n";
    if (line == "$$")
      return habits_.lists_settings ? "$10=1\r\n$13=" + std::to_string(int{habits_.inches}) +
                                          "\r\n$110=500.000\r\nok\r\n"
                                    : "ok\r\n";
    static const std::regex word("([A-Z])(-?[0-9.]+)");
    bool move = false, declare = false;
    double value = NAN, feed = NAN;
    const std::string text = std::regex_replace(line, std::regex(" "), "");
    std::size_t used = 0;
    for (std::sregex_iterator it(text.begin(), text.end(), word), end; it != end; ++it) {
      const char letter = (*it)[1].str()[0];
      const double number = std::strtod((*it)[2].str().c_str(), nullptr);
      used += it->str().size();
      if (letter == 'G' && number == 90) absolute_ = true;
      if (letter == 'G' && number == 91) absolute_ = false;
      if (letter == 'G' && number == 1) move = true;
      if (letter == 'G' && number == 92) declare = true;
      if (letter == 'X') value = number;
      if (letter == 'F') feed = number;
    }
    if (used != text.size()) return "error:2\r\n";
    if (declare) offset_ = motor.counted_deg - value;
    if (move && !(feed > 0)) return "error:22\r\n";
    if (move) {
      motor.target_deg = absolute_ ? value + offset_ : motor.target_deg + value;
      ++moves;
      early_idle_ = habits_.early_idle;
      if (moves == habits_.limit_at_move) {
        motor.target_deg = motor.counted_deg;
        deaf_ = true;
        return "ALARM:1\r\n";
      }
    }
    return habits_.two_oks ? "ok\r\nok\r\n" : "ok\r\n";
  }

  std::string line_;
  double offset_ = 0;
  bool absolute_ = true, held_ = false, alarm_ = false, deaf_ = false;
  int reports_ = 0, early_idle_ = 0;
  GrblHabits habits_;
};

}  // namespace

std::unique_ptr<Protocol> MakeGrblFirmware(const GrblHabits& habits) {
  return std::make_unique<GrblFirmware>(habits);
}

}  // namespace keypose::capture::shoot
