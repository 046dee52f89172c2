#include "fit/bending/schedule.h"

#include <gtest/gtest.h>

namespace keypose::fit::schedule_test {

TEST(Rounds, GetSofterAndFinerTowardsTheEnd) {
  std::vector<Round> rounds = FarRounds(true);
  for (const Round& round : NearRounds()) rounds.push_back(round);
  for (std::size_t r = 1; r < rounds.size(); ++r) {
    EXPECT_LE(rounds[r].stiffness, rounds[r - 1].stiffness) << r;
    EXPECT_LE(rounds[r].level, rounds[r - 1].level) << r;
  }
  EXPECT_EQ(rounds.back().level, 0);
}

TEST(Rounds, UnknownCamerasFindEachOtherWhileTheShapeIsStiff) {
  const std::vector<Round> known = FarRounds(true), unknown = FarRounds(false);
  ASSERT_GT(unknown.size(), known.size());
  for (std::size_t r = 0; r < unknown.size() - known.size(); ++r)
    EXPECT_GT(unknown[r].stiffness, known.front().stiffness);
}

TEST(Rounds, WithoutATextureNoFeatureIsAskedFor) {
  for (const Round& round : UntexturedRounds()) EXPECT_EQ(round.features, 0);
}

TEST(MarkScale, PicksReachFarthestBeforeOutlinesHold) {
  const double at_first = MarkScale(FarRounds(true).front());
  for (const Round& round : NearRounds()) EXPECT_LT(MarkScale(round), at_first);
}

}  // namespace keypose::fit::schedule_test
