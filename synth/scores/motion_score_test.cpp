#include "synth/scores/motion_score.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::synth::motion_score_test {

using Frames = std::vector<Eigen::VectorXd>;

/// Two joints, of which one runs along a parabola whose second difference is 2 mm, one rests.
Frames Truth(int frames) {
  Frames places;
  for (int f = 0; f < frames; ++f) {
    places.emplace_back(Eigen::VectorXd::Zero(6));
    places.back()[1] = 0.001 * f * f;
  }
  return places;
}

TEST(Trembling, AnErrorThatStaysIsNone) {
  Frames tracked = Truth(9);
  for (Eigen::VectorXd& frame : tracked) frame.array() += 0.05;
  const Trembling found = TremblingOf(tracked, Truth(9));
  EXPECT_NEAR(found.second_difference, 1, 1e-12);
  EXPECT_NEAR(found.trembling_m, 0, 1e-15);
}

TEST(Trembling, AnErrorThatChangesSignsCountsFourfold) {
  Frames tracked = Truth(9);
  for (std::size_t f = 0; f < tracked.size(); ++f) tracked[f][5] = f % 2 ? 0.003 : -0.003;
  const Trembling found = TremblingOf(tracked, Truth(9));
  EXPECT_NEAR(found.trembling_m, 4 * 0.003 / 2, 1e-15) << "of the two joints' mean";
  EXPECT_NEAR(found.second_difference, (0.002 + 4 * 0.003) / 0.002, 1e-9);
}

TEST(Trembling, SmearedMotionIsBelowOneAndCountsAsError) {
  Frames tracked = Truth(9);
  for (Eigen::VectorXd& frame : tracked) frame *= 0.5;
  const Trembling found = TremblingOf(tracked, Truth(9));
  EXPECT_NEAR(found.second_difference, 0.5, 1e-12);
  EXPECT_NEAR(found.trembling_m, 0.0005, 1e-15);
}

TEST(Trembling, TwoFramesSayNothing) {
  const Trembling found = TremblingOf(Truth(2), Truth(2));
  EXPECT_EQ(found.second_difference, 0);
  EXPECT_EQ(found.trembling_m, 0);
}

}  // namespace keypose::synth::motion_score_test
