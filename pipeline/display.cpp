#include "pipeline/display.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace keypose::pipeline {
namespace {

std::string Left(const std::optional<double>& seconds) { return seconds ? fmt::format(", {} left", DurationText(*seconds)) : ""; }

std::string FinishedText(const std::string& step, const std::string& status, double seconds) {
  if (status == "made") return fmt::format("{} made in {}", step, DurationText(seconds));
  return fmt::format("{} {} after {}", step, status, DurationText(seconds));
}

/// What all displays keep track of.
class Display : public RunObserver {
 public:
  explicit Display(const Clock& clock) : clock_(clock) {}
  void Begin(const std::map<std::string, double>& expected_seconds) override { estimate_.Begin(expected_seconds); }
  void Started(const std::string& step, const std::vector<std::string>&, int) override { estimate_.Started(step, clock_.Now()); }
  void Progressed(const std::string& step, double fraction, const std::string&) override { estimate_.Progressed(step, fraction); }
  void Finished(const std::string& step, const std::string& status, double seconds) override {
    up_to_date_ += status == "cached";
    made_ += status == "made";
    estimate_.Finished(step, status == "cached" ? 0 : seconds);
  }

 protected:
  double Percent() const { return 100 * estimate_.Fraction(clock_.Now()); }
  std::optional<double> SecondsLeft() const { return estimate_.SecondsLeft(clock_.Now()); }
  std::string Summary() const {
    const std::string up_to_date = fmt::format("{} step{} up to date", up_to_date_, up_to_date_ == 1 ? "" : "s");
    return made_ ? fmt::format("{} made, {}", made_, up_to_date) : up_to_date;
  }

  const Clock& clock_;
  Estimate estimate_;
  int up_to_date_ = 0, made_ = 0;
};

class Lines final : public Display {
 public:
  using Display::Display;
  void Started(const std::string& step, const std::vector<std::string>& reasons, int threads) override {
    Display::Started(step, reasons, threads);
    Print(fmt::format("{} starts on {} core{}: {}", step, threads, threads == 1 ? "" : "s", fmt::join(reasons, "; ")));
    last_line_[step] = clock_.Now();
  }
  void Progressed(const std::string& step, double fraction, const std::string& what) override {
    constexpr double kSecondsBetweenLines = 10;
    Display::Progressed(step, fraction, what);
    if (clock_.Now() - last_line_[step] < kSecondsBetweenLines) return;
    last_line_[step] = clock_.Now();
    Print(fmt::format("{} {:.0f} % {}", step, 100 * fraction, what));
  }
  void Finished(const std::string& step, const std::string& status, double seconds) override {
    Display::Finished(step, status, seconds);
    if (status != "cached") Print(FinishedText(step, status, seconds));
  }
  void Note(const std::string& line) override { Print(line); }
  void End() override { Print(Summary()); }

 private:
  void Print(const std::string& line) {
    if (estimate_.total() == 0) {
      std::puts(line.c_str());
    } else {
      fmt::print("[{:3.0f} %{}] {}\n", Percent(), Left(SecondsLeft()), line);
    }
    std::fflush(stdout);
  }
  std::map<std::string, double> last_line_;
};

class Bars final : public Display {
 public:
  using Display::Display;
  void Started(const std::string& step, const std::vector<std::string>& reasons, int threads) override {
    Display::Started(step, reasons, threads);
    running_[step] = {clock_.Now(), reasons.empty() ? "" : reasons.front()};
    Draw();
  }
  void Progressed(const std::string& step, double fraction, const std::string& what) override {
    Display::Progressed(step, fraction, what);
    running_[step].second = what;
  }
  void Finished(const std::string& step, const std::string& status, double seconds) override {
    Display::Finished(step, status, seconds);
    running_.erase(step);
    if (status != "cached") Above(FinishedText(step, status, seconds));
  }
  void Note(const std::string& line) override { Above(line); }
  void Tick() override { Draw(); }
  void End() override {
    running_.clear();
    Clear();
    std::puts(Summary().c_str());
  }

 private:
  void Above(const std::string& line) {
    Clear();
    std::puts(line.c_str());
    Draw();
  }
  void Clear() {
    if (drawn_ > 0) fmt::print("\x1b[{}A\x1b[J", drawn_);
    drawn_ = 0;
  }
  static std::string Bar(double fraction) {
    constexpr int kWidth = 24;
    const int full = static_cast<int>(fraction * kWidth + 0.5);
    return "[" + std::string(static_cast<std::size_t>(full), '#') + std::string(static_cast<std::size_t>(kWidth - full), '.') + "]";
  }
  static std::size_t Columns() {
    winsize size{};
    return ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
  }
  void Draw() {
    Clear();
    const std::size_t columns = Columns();
    const auto print = [&](std::string line) {
      if (line.size() >= columns) line.resize(columns - 1);
      std::puts(line.c_str());
      ++drawn_;
    };
    for (const auto& [step, state] : running_) {
      const double fraction = estimate_.FractionOf(step);
      print(fmt::format("{} {:3.0f} % {:<20} {} {}", Bar(fraction), 100 * fraction, step, DurationText(clock_.Now() - state.first),
                        state.second));
    }
    if (!running_.empty()) {
      print(fmt::format("{} {:3.0f} % of all, {} of {} steps{}", Bar(Percent() / 100), Percent(), estimate_.finished(), estimate_.total(),
                        Left(SecondsLeft())));
    }
    std::fflush(stdout);
  }
  std::map<std::string, std::pair<double, std::string>> running_;
  int drawn_ = 0;
};

class JsonLines final : public Display {
 public:
  using Display::Display;
  void Begin(const std::map<std::string, double>& expected_seconds) override {
    Display::Begin(expected_seconds);
    Print({{"event", "begin"}, {"steps_to_run", expected_seconds.size()}});
  }
  void Started(const std::string& step, const std::vector<std::string>& reasons, int threads) override {
    Display::Started(step, reasons, threads);
    Print({{"event", "start"}, {"step", step}, {"threads", threads}, {"reasons", reasons}});
  }
  void Progressed(const std::string& step, double fraction, const std::string& what) override {
    Display::Progressed(step, fraction, what);
    Print({{"event", "progress"}, {"step", step}, {"fraction", fraction}, {"what", what}});
  }
  void Finished(const std::string& step, const std::string& status, double seconds) override {
    Display::Finished(step, status, seconds);
    Print({{"event", "finish"}, {"step", step}, {"status", status}, {"seconds", seconds}});
  }
  void Note(const std::string& line) override { Print({{"event", "note"}, {"text", line}}); }
  void End() override { Print({{"event", "end"}}); }

 private:
  void Print(nlohmann::json line) {
    line["overall"] = Percent() / 100;
    if (const auto left = SecondsLeft()) line["seconds_left"] = *left;
    std::puts(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace).c_str());
    std::fflush(stdout);
  }
};

}  // namespace

std::unique_ptr<RunObserver> MakeDisplay(DisplayKind kind, const Clock& clock) {
  if (kind == DisplayKind::kBars) return std::make_unique<Bars>(clock);
  if (kind == DisplayKind::kJsonLines) return std::make_unique<JsonLines>(clock);
  return std::make_unique<Lines>(clock);
}

}  // namespace keypose::pipeline
