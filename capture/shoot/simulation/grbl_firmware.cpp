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

class GrblFirmware final : public Protocol {
 public:
  std::string Reset(int) override {
    offset_ = 0;
    absolute_ = true;
    held_ = alarm_ = false;
    line_.clear();
    reports_ = 0;
    return "\r\nGrbl 1.1h ['$' for help]\r\n";
  }

  std::string Receive(const std::string& bytes, SimulatedMotor& motor) override {
    std::string replies;
    for (const char c : bytes) {
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
    const char* state = motor.moving() ? "Run" : "Idle";
    if (held_) state = "Hold:0";
    if (alarm_) state = "Alarm";
    char text[128];
    std::snprintf(text, sizeof text, "<%s|MPos:%.3f,0.000,0.000|FS:0,0", state, motor.counted_deg);
    std::string report = text;
    if (reports_++ % 10 == 0) {
      std::snprintf(text, sizeof text, "|WCO:%.3f,0.000,0.000", offset_);
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
    }
    return "ok\r\n";
  }

  std::string line_;
  double offset_ = 0;
  bool absolute_ = true, held_ = false, alarm_ = false;
  int reports_ = 0;
};

}  // namespace

std::unique_ptr<Protocol> MakeGrblFirmware() { return std::make_unique<GrblFirmware>(); }

}  // namespace keypose::capture::shoot
