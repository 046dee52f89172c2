// `keypose synth photos` with mishaps: each changes only what it should, in the right photographs
// only.
#include "synth/photographs/mishaps.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/values/errors.h"

namespace keypose::synth::mishaps_test {

TEST(Mishaps, StrayAndHeldPhotographsAreSpreadAndNeverTheSame) {
  Mishaps mishaps;
  mishaps.strays = 3;
  mishaps.hands = 5;
  const std::vector<int> strays = StrayViews(mishaps, 24), hands = HandViews(mishaps, 24);
  EXPECT_EQ(strays, (std::vector<int>{3, 11, 19}));
  ASSERT_EQ(hands.size(), 5u);
  for (std::size_t k = 1; k < hands.size(); ++k) EXPECT_GE(hands[k] - hands[k - 1], 3);
  for (const int i : hands) EXPECT_FALSE(std::binary_search(strays.begin(), strays.end(), i));
}

TEST(Mishaps, MovesAreReadAndOtherFormsAreRefused) {
  Mishaps mishaps;
  ReadMove("0.25:-5mm,7.5deg", &mishaps);
  EXPECT_DOUBLE_EQ(mishaps.moved_from, 0.25);
  EXPECT_DOUBLE_EQ(mishaps.moved_m, -0.005);
  EXPECT_NEAR(mishaps.moved_rad, 0.1308996938995747, 1e-15);
  ReadMove("0.5:bow", &mishaps);
  EXPECT_EQ(mishaps.moved_pose, "bow");
  for (const char* bad :
       {"", "0.5", "0.5:", "half:5mm", "0.5:5", "0.5:5cm", "0.5:5mm,", "0.5:5mm;7deg"}) {
    Mishaps none;
    EXPECT_THROW(ReadMove(bad, &none), UsageError) << bad;
  }
}

TEST(Mishaps, ImpossibleOnesAreNamed) {
  Mishaps mishaps;
  mishaps.strays = 5, mishaps.hands = 4;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
  mishaps = {};
  mishaps.lamp_falls_after = 1.5;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
  mishaps = {};
  mishaps.moved_m = 5;
  EXPECT_EQ(mishaps.Problems(8).size(), 1u);
}

}  // namespace keypose::synth::mishaps_test
