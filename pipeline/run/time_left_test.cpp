#include "pipeline/run/time_left.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace keypose::pipeline::time_left_test {

using From = Expected::From;

/// A run in which everything is known: a step's work in seconds of an idle machine, and how many
/// times slower the machine is at each moment.
struct Past {
  struct Step {
    std::string name;
    double work = 0;
    bool tells = true;  ///< its progress, ten times a second; else nothing until its end
  };
  std::vector<Step> steps;  ///< one after the other
  std::function<double(double)> slowness = [](double) { return 1.0; };
};

struct Moment {
  double time = 0, truth = 0;
  SecondsLeft left;
};

/// What is said in each second of it.
std::vector<Moment> Played(const Past& past, const Forecast& forecast) {
  TimeLeft estimate;
  estimate.Begin(forecast, 0);
  std::vector<Moment> moments;
  double now = 0, next = 0;
  for (const auto& step : past.steps) {
    estimate.Started(step.name, now, 1);
    for (double done = 0; done < step.work;) {
      if (now >= next) {
        if (const auto left = estimate.Left(now)) moments.push_back({now, 0, *left});
        next += 1;
      }
      now += 0.1;
      done += 0.1 / past.slowness(now);
      if (step.tells) estimate.Progressed(step.name, now, std::min(1.0, done / step.work));
    }
    estimate.Finished(step.name, now, "made");
  }
  for (Moment& moment : moments) moment.truth = now - moment.time;
  return moments;
}

/// Six steps of 30 to 90 s, and what is expected of them: 15 % more or less.
Past SixSteps(bool tells) {
  Past past;
  const double work[] = {40, 60, 30, 90, 45, 75};
  for (int i = 0; i < 6; ++i) past.steps.push_back({"step" + std::to_string(i), work[i], tells});
  return past;
}
Forecast ForecastOf(const Past& past, From from) {
  const double wrong[] = {1.15, 0.9, 1.1, 0.87, 1.05, 0.95};
  Forecast forecast;
  int i = 0;
  for (const auto& step : past.steps)
    forecast.steps[step.name] = {from, wrong[i++ % 6] * step.work, 1, {}};
  return forecast;
}

std::vector<Moment> After(double time, std::vector<Moment> moments) {
  std::erase_if(moments, [&](const Moment& moment) { return moment.time < time; });
  return moments;
}

/// Share of the moments at which the truth lay in the range.
double ShareInRange(const std::vector<Moment>& moments) {
  const auto in = std::count_if(moments.begin(), moments.end(), [](const Moment& m) {
    return m.left.low <= m.truth && m.truth <= m.left.high;
  });
  return static_cast<double>(in) / static_cast<double>(moments.size());
}

/// The most that the likely time was wrong by, as a factor; less than 20 s do not count.
double WorstFactor(const std::vector<Moment>& moments) {
  double worst = 1;
  for (const Moment& m : moments) {
    if (std::abs(m.truth - m.left.likely) < 20) continue;
    worst = std::max({worst, m.left.likely / m.truth, m.truth / m.left.likely});
  }
  return worst;
}

TEST(TimeLeft, WhatIsWellKnownIsNearlyRightFromTheStart) {
  const Past past = SixSteps(true);
  const auto moments = Played(past, ForecastOf(past, From::kOwnRun));
  EXPECT_GT(ShareInRange(moments), 0.95);
  EXPECT_LT(WorstFactor(moments), 1.25);
  EXPECT_LT(moments.front().left.high / moments.front().left.low, 3);
  EXPECT_NEAR(moments.front().left.likely, 335, 10);
}

TEST(TimeLeft, AMachineHalfAsFastIsKnownFromTheFirstStep) {
  for (const From from : {From::kOwnRun, From::kCost}) {
    Past past = SixSteps(true);
    past.slowness = [](double) { return 2.0; };
    const auto moments = Played(past, ForecastOf(past, from));
    EXPECT_NEAR(moments.front().left.likely, 340, 15) << "nobody can know";
    EXPECT_GT(ShareInRange(After(25, moments)), 0.9);
    EXPECT_LT(WorstFactor(After(25, moments)), 1.8);
    EXPECT_LT(WorstFactor(After(100, moments)), 1.4);
  }
}

TEST(TimeLeft, AMachineHalfAsFastIsKnownFromStepsThatSayNothingUntilTheirEnd) {
  for (const From from : {From::kOwnRun, From::kCost}) {
    Past past = SixSteps(false);
    past.slowness = [](double) { return 2.0; };
    const auto moments = Played(past, ForecastOf(past, from));
    EXPECT_GT(ShareInRange(After(60, moments)), 0.85);
    auto later = After(100, moments);
    std::erase_if(later, [](const Moment& moment) { return moment.truth < 60; });
    EXPECT_LT(WorstFactor(later), 1.6);
  }
}

TEST(TimeLeft, ALoadThatBeginsMidwayIsNoticed) {
  Past past = SixSteps(true);
  past.slowness = [](double time) { return time < 100 ? 1.0 : 4.0; };
  const auto moments = Played(past, ForecastOf(past, From::kOwnRun));
  EXPECT_NEAR(moments.front().left.likely, 340, 15);
  EXPECT_GT(moments.front().truth, 1000) << "nobody can know at the start";
  EXPECT_GT(ShareInRange(After(230, moments)), 0.9);
  EXPECT_LT(WorstFactor(After(230, moments)), 1.6) << "from the first step's end on";
}

TEST(TimeLeft, ALoadThatEndsMidwayIsNoticed) {
  Past past = SixSteps(true);
  past.slowness = [](double time) { return time < 400 ? 4.0 : 1.0; };
  const auto moments = Played(past, ForecastOf(past, From::kOwnRun));
  EXPECT_LT(WorstFactor(After(450, moments)), 1.6);
}

TEST(TimeLeft, ALoadThatIsThereFromTheStartIsInTheFirstRange) {
  Past past = SixSteps(true);
  past.slowness = [](double) { return 4.5; };
  Forecast forecast = ForecastOf(past, From::kCost);
  forecast.cores = 2;
  for (auto& [name, expected] : forecast.steps)
    if (name != "step0") expected.needs = {"step" + std::to_string(name.back() - '1')};
  forecast.load = 7;
  const auto moments = Played(past, forecast);
  EXPECT_LT(moments.front().left.low, moments.front().truth);
  EXPECT_GT(moments.front().left.high, moments.front().truth);
  EXPECT_LT(WorstFactor(After(60, moments)), 1.5);
}

TEST(TimeLeft, ProgressThatIsFarFromEvenTellsLittleOfTheMachine) {
  // Each step says 90 % after a fifth of its time.
  TimeLeft estimate;
  estimate.Begin({{{"a", {From::kOwnRun, 40, 1, {}}},
                   {"b", {From::kOwnRun, 40, 1, {"a"}}},
                   {"c", {From::kOwnRun, 40, 1, {"b"}}}},
                  1},
                 0);
  double begin = 0;
  for (const char* step : {"a", "b", "c"}) {
    estimate.Started(step, begin, 1);
    for (int i = 1; i <= 9; ++i) estimate.Progressed(step, begin + i, 0.1 * i);
    for (double now = begin + 10; now < begin + 40; now += 5) {
      EXPECT_GT(estimate.Left(now)->high, 0.5 * (80 - begin)) << now;
      EXPECT_LT(estimate.Left(now)->low, 1.5 * (120 - now)) << now;
    }
    estimate.Finished(step, begin + 40, "made");
    begin += 40;
    if (begin < 120) {
      EXPECT_NEAR(estimate.Left(begin)->likely, 120 - begin, 0.2 * (120 - begin));
    }
  }
}

TEST(TimeLeft, WithoutHistoryItSaysNothingThenARange) {
  Past past = SixSteps(true);
  Forecast forecast;
  for (const auto& step : past.steps) forecast.steps[step.name] = {};
  TimeLeft estimate;
  estimate.Begin(forecast, 0);
  EXPECT_FALSE(estimate.Left(0));
  const auto moments = Played(past, forecast);
  EXPECT_GE(moments.front().time, 40) << "the first step's end is the first that is known";
  EXPECT_GT(ShareInRange(moments), 0.9);
  EXPECT_GT(moments.front().left.high, 1.8 * moments.front().left.low);
}

TEST(TimeLeft, OneStepFarLongerThanEverNeverSticksAtZero) {
  for (const bool tells : {true, false}) {
    Past past = SixSteps(tells);
    const Forecast forecast = ForecastOf(past, From::kOwnRun);
    past.steps.back().work = 1500;
    const auto moments = Played(past, forecast);
    const double begin = 265;
    for (const Moment& m : After(begin + 100, moments)) {
      const double at_work = m.time - begin;
      if (m.truth < 60) continue;
      EXPECT_GT(m.left.likely, std::min(0.2 * at_work, 0.5 * m.truth)) << m.time;
      EXPECT_GT(m.left.high, 1.35 * m.left.low) << m.time << ": it knows that it does not know";
    }
    if (tells) {
      EXPECT_LT(WorstFactor(After(begin + 300, moments)), 1.5);
    }
  }
}

TEST(TimeLeft, StepsSideBySideShareTheTime) {
  TimeLeft estimate;
  estimate.Begin({{{"a", {From::kOwnRun, 40, 1, {}}},
                   {"b", {From::kOwnRun, 40, 1, {}}},
                   {"c", {From::kOwnRun, 10, 2, {"a", "b"}}}},
                  2},
                 0);
  EXPECT_DOUBLE_EQ(estimate.Left(0)->likely, 50);
  estimate.Begin({{{"a", {From::kOwnRun, 40, 1, {}}}, {"b", {From::kOwnRun, 40, 1, {"a"}}}}, 2}, 0);
  EXPECT_DOUBLE_EQ(estimate.Left(0)->likely, 80) << "one after the other, whatever cores are free";
}

TEST(TimeLeft, AStepOfWhichNothingIsKnownCountsAsAnAverageOne) {
  TimeLeft estimate;
  estimate.Begin(
      {{{"a", {From::kOwnRun, 10, 1, {}}}, {"b", {From::kOwnRun, 30, 1, {}}}, {"own", {}}}, 1}, 0);
  EXPECT_DOUBLE_EQ(estimate.Left(0)->likely, 60);
}

TEST(TimeLeft, CachedAndFailedStepsTellNothingOfTheMachine) {
  for (const char* status : {"cached", "failed"}) {
    TimeLeft estimate;
    estimate.Begin({{{"a", {From::kOwnRun, 10, 1, {}}}, {"b", {From::kOwnRun, 30, 1, {}}}}, 1}, 0);
    estimate.Started("a", 0, 1);
    estimate.Finished("a", 0.1, status);
    EXPECT_DOUBLE_EQ(estimate.Left(0.1)->likely, 30) << status;
  }
}

TEST(TimeLeft, FractionIsOfTheTimeAndNeverWholeWhileAStepRuns) {
  TimeLeft estimate;
  estimate.Begin({{{"a", {From::kOwnRun, 10, 1, {}}}, {"b", {From::kOwnRun, 30, 1, {}}}}, 1}, 0);
  EXPECT_DOUBLE_EQ(estimate.Fraction(0), 0);
  estimate.Started("a", 0, 1);
  estimate.Finished("a", 10, "made");
  EXPECT_NEAR(estimate.Fraction(10), 0.25, 1e-9);
  estimate.Started("b", 10, 1);
  estimate.Progressed("b", 30, 1);
  EXPECT_LT(estimate.Fraction(30), 1);
  EXPECT_LT(estimate.FractionOf("b"), 1);
  estimate.Finished("never announced", 30, "cached");
  estimate.Finished("b", 40, "made");
  EXPECT_EQ(estimate.total(), 2);
  EXPECT_DOUBLE_EQ(estimate.Fraction(40), 1);
}

TEST(TimeLeft, FractionCountsStepsWhileNothingIsKnown) {
  TimeLeft estimate;
  estimate.Begin({{{"a", {}}, {"b", {}}}, 1}, 0);
  estimate.Started("a", 0, 1);
  estimate.Progressed("a", 5, 0.05);
  EXPECT_DOUBLE_EQ(estimate.Fraction(5), 0.025);
}

TEST(RangeText, IsAsFineAsItIsKnown) {
  EXPECT_EQ(RangeText({115, 125, 135}), "2 min 05 s");
  EXPECT_EQ(RangeText({100, 180, 320}), "2 to 5 min");
  EXPECT_EQ(RangeText({41, 70, 118}), "40 s to 2 min");
  EXPECT_EQ(RangeText({0, 2, 7}), "about 5 s");
  EXPECT_EQ(RangeText({12, 20, 33}), "10 to 35 s");
  EXPECT_EQ(RangeText({91, 110, 148}), "about 2 min");
  EXPECT_EQ(RangeText({1800, 4000, 9000}), "30 min to 2 h 30 min");
  EXPECT_EQ(RangeText({3500, 5000, 7100}), "58 min to 2 h");
  EXPECT_EQ(RangeText({4100, 5800, 8300}), "1 h 10 min to 2 h 20 min");
}

TEST(DurationText, Grows) {
  EXPECT_EQ(DurationText(0.25), "0.2 s");
  EXPECT_EQ(DurationText(42), "42 s");
  EXPECT_EQ(DurationText(125), "2 min 05 s");
  EXPECT_EQ(DurationText(4320), "1 h 12 min");
}

}  // namespace keypose::pipeline::time_left_test
