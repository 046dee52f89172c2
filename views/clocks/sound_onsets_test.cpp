#include "views/clocks/sound_onsets.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace keypose::sound_onsets_test {

/// A room with claps, recorded at a gain, by a recorder that was started `begin_s` after the room.
SoundPower Recorded(const std::vector<double>& claps_s, double seconds, double begin_s, double gain,
                    double noise, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> grain(0.5, 1.5);
  SoundPower power;
  for (int i = 0; i < 1000 * seconds; ++i) {
    double sum = noise * grain(random);
    for (const double clap : claps_s) {
      // the part of this millisecond after the clap, and its echo that fades
      const double after = begin_s + 0.001 * (i + 1) - clap;
      if (after > 0 && after < 0.5) sum += std::min(1.0, 1000 * after) * std::exp(-after / 0.03);
    }
    power.per_milli.push_back(static_cast<float>(gain * sum));
  }
  return power;
}

TEST(SoundOnsets, OneClapTellsTheOffsetToHalfAMillisecond) {
  for (const double begin : {0.0, 1.2344, 3.7}) {
    const Signal a = SoundOnsets(Recorded({5.0}, 12, 0, 1, 1e-4, 1));
    const Signal b = SoundOnsets(Recorded({5.0}, 9, begin, 0.05, 3e-4, 2));
    const ClockOffset found = CorrelateSignals(a, b, {.trend_s = 0.5});
    EXPECT_TRUE(found.confident) << begin;
    EXPECT_NEAR(found.seconds, -begin, 5e-4) << begin;
  }
}

TEST(SoundOnsets, NoiseOfTwoRoomsAndSilenceTellNothing) {
  for (unsigned seed = 1; seed < 40; ++seed)
    EXPECT_FALSE(CorrelateSignals(SoundOnsets(Recorded({}, 10, 0, 1, 1e-3, seed)),
                                  SoundOnsets(Recorded({}, 10, 0, 1, 1e-3, 99 + seed)),
                                  {.trend_s = 0.5})
                     .confident)
        << seed;
  EXPECT_TRUE(SoundOnsets({0, std::vector<float>(1000, 0)}).values.empty());
  EXPECT_TRUE(SoundOnsets({}).values.empty());
}

}  // namespace keypose::sound_onsets_test
