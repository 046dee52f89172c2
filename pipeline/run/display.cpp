#include "pipeline/run/display.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/run/time_left.h"
#include "pipeline/text/terminal.h"
#include "pipeline/text/text.h"

namespace keypose::pipeline {
namespace {

std::string LeftText(const std::optional<SecondsLeft>& left) {
  return left ? fmt::format(", {} left", RangeText(*left)) : "";
}

std::string FinishedText(const std::string& step, const std::string& status, double seconds) {
  if (status == "made") return fmt::format("{} made in {}", step, DurationText(seconds));
  return fmt::format("{} {} after {}", step, status, DurationText(seconds));
}

/// State and texts that all displays share.
class Display : public RunObserver {
 public:
  explicit Display(const Clock& clock) : clock_(clock) {}
  void Begin(const Forecast& forecast) override { estimate_.Begin(forecast, clock_.Now()); }
  void Started(const std::string& step, const std::vector<std::string>&, int threads) override {
    estimate_.Started(step, clock_.Now(), threads);
  }
  void Progressed(const std::string& step, double fraction, const std::string&) override {
    estimate_.Progressed(step, clock_.Now(), fraction);
  }
  void Finished(const std::string& step, const std::string& status, double) override {
    up_to_date_ += status == "cached";
    made_ += status == "made";
    failed_ += status == "failed";
    estimate_.Finished(step, clock_.Now(), status);
  }

 protected:
  /// Never decreases, even if the estimate of the remaining time grows.
  double Fraction() { return fraction_ = std::max(fraction_, estimate_.Fraction(clock_.Now())); }
  /// Rounded down: 100 only when all is done.
  int Percent() { return static_cast<int>(100 * Fraction()); }
  std::optional<SecondsLeft> Left() const { return estimate_.Left(clock_.Now()); }
  std::string Summary() const {
    const std::string up_to_date =
        fmt::format("{} step{} up to date", up_to_date_, up_to_date_ == 1 ? "" : "s");
    std::string text = made_ ? fmt::format("{} made, {}", made_, up_to_date) : up_to_date;
    if (failed_) text += fmt::format(", {} failed", failed_);
    return text;
  }
  /// The text at the end of a run: warnings, verdicts and results.
  std::string Closing(const Ending& ending) const {
    const std::size_t columns = TerminalColumns();
    // An interrupted run with nothing to show prints only that it was interrupted.
    std::string text =
        estimate_.total() > 0 && up_to_date_ + made_ + failed_ == 0 ? "" : Summary() + "\n";
    for (const std::string& part :
         {WarningsText(ending, columns), VerdictsText(ending, columns), ResultsText(ending)})
      text += part.empty() ? "" : "\n" + part;
    return text;
  }

  const Clock& clock_;
  TimeLeft estimate_;
  int up_to_date_ = 0, made_ = 0, failed_ = 0;
  double fraction_ = 0;
};

class Lines final : public Display {
 public:
  using Display::Display;
  void Started(const std::string& step, const std::vector<std::string>& reasons,
               int threads) override {
    Display::Started(step, reasons, threads);
    Print(fmt::format("{} starts on {} core{}: {}", step, threads, threads == 1 ? "" : "s",
                      fmt::join(reasons, "; ")));
    last_line_[step] = clock_.Now();
  }
  void Progressed(const std::string& step, double fraction, const std::string& what) override {
    constexpr double kSecondsBetweenLines = 10;
    Display::Progressed(step, fraction, what);
    if (clock_.Now() - last_line_[step] < kSecondsBetweenLines) return;
    last_line_[step] = clock_.Now();
    Print(
        fmt::format("{} {} % {}", step, static_cast<int>(100 * estimate_.FractionOf(step)), what));
  }
  void Finished(const std::string& step, const std::string& status, double seconds) override {
    Display::Finished(step, status, seconds);
    last_line_.erase(step);
    if (status != "cached") Print(FinishedText(step, status, seconds));
  }
  void Note(const std::string& line) override { Print(line); }
  /// A step that is silent for long is shown to be at work.
  void Tick() override {
    constexpr double kSecondsOfSilence = 60;
    for (auto& [step, time] : last_line_) {
      if (clock_.Now() - time < kSecondsOfSilence) continue;
      time = clock_.Now();
      const int percent = static_cast<int>(100 * estimate_.FractionOf(step));
      Print(fmt::format("{} is still at work ({} %)", step, percent));
    }
  }
  void End(const Ending& ending) override { Say(Closing(ending)); }

 private:
  void Print(const std::string& line) {
    if (estimate_.total() == 0) return Say(line + "\n");
    Say(fmt::format("[{:3} %{}] {}\n", Percent(), LeftText(Left()), line));
  }
  std::map<std::string, double> last_line_;
};

class Bars final : public Display {
 public:
  using Display::Display;
  void Started(const std::string& step, const std::vector<std::string>& reasons,
               int threads) override {
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
  void End(const Ending& ending) override {
    running_.clear();
    Say(Cleared() + Closing(ending));
  }

 private:
  void Above(const std::string& line) {
    Say(Cleared() + line + "\n");
    Draw();
  }
  /// The control sequence that clears the bars from the screen.
  std::string Cleared() {
    const std::string text = drawn_ > 0 ? fmt::format("\x1b[{}A\x1b[J", drawn_) : "";
    drawn_ = 0;
    return text;
  }
  static std::string Bar(double fraction) {
    constexpr int kWidth = 24;
    const int full = static_cast<int>(fraction * kWidth + 0.5);
    return "[" + std::string(static_cast<std::size_t>(full), '#') +
           std::string(static_cast<std::size_t>(kWidth - full), '.') + "]";
  }
  /// One write for all, so that the bars do not flicker.
  void Draw() {
    std::string text = Cleared();
    const std::size_t columns = TerminalColumns() > 0 ? TerminalColumns() : 80;
    const auto add = [&](const std::string& line) {
      text += CutTo(line, columns - 1) + "\n";
      ++drawn_;
    };
    for (const auto& [step, state] : running_) {
      const double fraction = estimate_.FractionOf(step);
      add(fmt::format("{} {:3} % {:<20} {} {}", Bar(fraction), static_cast<int>(100 * fraction),
                      step, DurationText(clock_.Now() - state.first), state.second));
    }
    if (!running_.empty()) {
      add(fmt::format("{} {:3} % of all, {} of {} steps{}", Bar(Fraction()), Percent(),
                      estimate_.finished(), estimate_.total(), LeftText(Left())));
    }
    Say(text);
  }
  std::map<std::string, std::pair<double, std::string>> running_;
  int drawn_ = 0;
};

class JsonLines final : public Display {
 public:
  using Display::Display;
  void Begin(const Forecast& forecast) override {
    Display::Begin(forecast);
    Print({{"event", "begin"}, {"steps_to_run", forecast.steps.size()}});
  }
  void Started(const std::string& step, const std::vector<std::string>& reasons,
               int threads) override {
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
  /// The time left is told anew where no step says anything.
  void Tick() override {
    constexpr double kSecondsOfSilence = 2;
    if (clock_.Now() - last_line_ >= kSecondsOfSilence) Print({{"event", "time"}});
  }
  void End(const Ending& ending) override {
    PrintAll("warning", ending.warnings);
    PrintAll("verdict", ending.verdicts);
    PrintAll("result", ending.results);
    Print({{"event", "end"}});
  }

 private:
  template <class Items>
  void PrintAll(const std::string& event, const Items& items) {
    for (const auto& item : items) {
      nlohmann::json line = ToJson(item);
      line["event"] = event;
      Print(std::move(line));
    }
  }
  void Print(nlohmann::json line) {
    line["overall"] = Fraction();
    if (const auto left = Left()) {
      line["seconds_left"] = left->likely;
      line["seconds_left_range"] = {left->low, left->high};
    }
    last_line_ = clock_.Now();
    Say(line.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n");
  }
  double last_line_ = 0;
};

}  // namespace

std::unique_ptr<RunObserver> MakeDisplay(DisplayKind kind, const Clock& clock) {
  if (kind == DisplayKind::kBars) return std::make_unique<Bars>(clock);
  if (kind == DisplayKind::kJsonLines) return std::make_unique<JsonLines>(clock);
  return std::make_unique<Lines>(clock);
}

}  // namespace keypose::pipeline
