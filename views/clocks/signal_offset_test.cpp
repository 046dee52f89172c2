#include "views/clocks/signal_offset.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/values/errors.h"
#include "views/clocks/correlation.h"

namespace keypose::signal_offset_test {

constexpr double kGrid = 240;  // per second

/// A movement that never repeats: bursts of different heights and lengths at any times.
class Event {
 public:
  explicit Event(unsigned seed, double seconds = 60) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> part(0, 1);
    for (double at = 0; at < seconds; at += 0.2 + 1.2 * part(random))
      bursts_.push_back({at, 0.5 + part(random), 0.08 + 0.2 * part(random)});
  }
  double operator()(double time_s) const {
    double sum = 0;
    for (const Burst& b : bursts_) {
      const double x = (time_s - b.at) / b.width;
      if (std::abs(x) < 6) sum += b.height * std::exp(-x * x);
    }
    return sum;
  }

 private:
  struct Burst {
    double at, height, width;
  };
  std::vector<Burst> bursts_;
};

/// What a camera of this rate sees of an event whose second 0 is at `begin_s` before its own 0.
Signal Filmed(const Event& event, double rate, double seconds, double begin_s, double noise,
              unsigned seed, double clock_rate = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> grain(0, noise);
  std::vector<double> times, values;
  for (int i = 0; i / rate < seconds; ++i) {
    times.push_back(i / rate);
    values.push_back(3 * event(clock_rate * i / rate + begin_s) + 1 + grain(random));
  }
  return Resampled(times, values, kGrid);
}

TEST(CrossCorrelation, IsTheSumOfProductsAtEachLag) {
  const std::vector<double> lags = CrossCorrelation({1, 2, 3}, {4, 5});
  ASSERT_EQ(lags.size(), 4u);  // -2, -1, 0, 1
  const double expected[] = {12, 8 + 15, 4 + 10, 5};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(lags[i], expected[i], 1e-12);
  EXPECT_TRUE(CrossCorrelation({}, {1}).empty());
}

TEST(CorrelateSignals, AFractionOfAFrameIsFound) {
  const Event event(1);
  for (const double frames : {0.0, 0.37, -0.5, 12.37, -101.63}) {
    const double begin = frames / 25;
    const ClockOffset found = CorrelateSignals(Filmed(event, 25, 20, 10, 0.05, 1),
                                               Filmed(event, 25, 20, 10 + begin, 0.05, 2), {});
    EXPECT_TRUE(found.confident) << frames << " " << found.peak << " " << found.second_peak << " "
                                 << found.sigmas;
    // what is at t in the first is earlier in the film that began later
    EXPECT_NEAR(25 * found.seconds, -frames, 0.05) << frames;
    EXPECT_NEAR(found.overlap_s, 20 - std::abs(begin), 0.1);
  }
}

TEST(CorrelateSignals, OtherRatesAndMuchNoiseMatterLittle) {
  const Event event(2);
  const ClockOffset found = CorrelateSignals(Filmed(event, 59.94, 25, 3, 0.5, 3),
                                             Filmed(event, 24, 30, 7.215, 0.5, 4), {});
  EXPECT_TRUE(found.confident);
  EXPECT_NEAR(found.seconds, -4.215, 0.15 / 24);
}

TEST(CorrelateSignals, WhatHasNothingInCommonIsNotConfident) {
  int confident = 0;
  for (unsigned seed = 0; seed < 60; ++seed)
    confident += CorrelateSignals(Filmed(Event(100 + seed), 30, 20, 0, 0.1, 5),
                                  Filmed(Event(300 + seed), 30, 20, 0, 0.1, 6), {})
                     .confident;
  EXPECT_EQ(confident, 0);
}

TEST(CorrelateSignals, APartInCommonThatIsTooShortIsNotConfident) {
  const Event event(3);
  const ClockOffset found =
      CorrelateSignals(Filmed(event, 30, 20, 0, 0.05, 5), Filmed(event, 30, 20, 19, 0.05, 6), {});
  EXPECT_FALSE(found.confident);
}

TEST(CorrelateSignals, AMovementThatRepeatsIsNotConfident) {
  std::vector<double> times, a, b;
  for (int i = 0; i < 600; ++i) {
    times.push_back(i / 30.0);
    a.push_back(std::pow(std::sin(3 * times.back()), 2));
    b.push_back(std::pow(std::sin(3 * times.back() + 0.6), 2));
  }
  EXPECT_FALSE(
      CorrelateSignals(Resampled(times, a, kGrid), Resampled(times, b, kGrid), {}).confident);
}

TEST(CorrelateSignals, NothingAndStillnessAreNotConfidentAndRatesMustBeTheSame) {
  const Signal still{0, 100, std::vector<double>(500, 2)}, none{0, 100, {}};
  EXPECT_FALSE(CorrelateSignals(still, still, {}).confident);
  EXPECT_FALSE(CorrelateSignals(none, still, {}).confident);
  EXPECT_THROW(CorrelateSignals(still, {0, 50, {1, 2}}, {}), UsageError);
}

TEST(CorrelateSignals, OnlyOffsetsWithinReachAreLookedAt) {
  const Event event(4);
  const Signal a = Filmed(event, 30, 20, 0, 0, 1), b = Filmed(event, 30, 20, 3, 0, 2);
  EXPECT_NEAR(CorrelateSignals(a, b, {}, -3, 0.3).seconds, -3, 0.002);
  EXPECT_LE(std::abs(CorrelateSignals(a, b, {}, 1, 0.3).seconds - 1), 0.31);
}

TEST(CorrelateDrifting, ClocksOfOneRateHaveNoDriftAndAFasterOneIsMeasured) {
  const Event event(5, 140);
  const Signal a = Filmed(event, 30, 120, 2, 0.05, 1);
  const ClockDrift same = CorrelateDrifting(a, Filmed(event, 30, 120, 4.5, 0.05, 2), {});
  ASSERT_TRUE(same.measured) << same.first_s << " " << same.last_s << " " << same.whole.peak << " "
                             << same.whole.sigmas;
  EXPECT_NEAR(same.last_s - same.first_s, 0, 0.002);
  // the second clock counts 1 s where 1.0008 s have passed: 64 ms less between the thirds' middles
  const ClockDrift fast = CorrelateDrifting(a, Filmed(event, 30, 120, 4.5, 0.05, 2, 1.0008), {});
  ASSERT_TRUE(fast.measured);
  EXPECT_NEAR(fast.per_second(), 1 / 1.0008 - 1, 4e-5);
}

TEST(Resampled, LiesOnStraightLines) {
  const Signal signal = Resampled({1, 2, 4}, {0, 1, 3}, 2);
  EXPECT_EQ(signal.first_s, 1);
  EXPECT_EQ(signal.values, (std::vector<double>{0, 0.5, 1, 1.5, 2, 2.5, 3}));
}

}  // namespace keypose::signal_offset_test
