#include "fit/following/calm.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::fit::calm_test {

TEST(Calmed, KeepsWhatStaysAndFillsWhatIsHidden) {
  std::vector<Offsets> frames(9, {PointsX3::Constant(2, 3, 0.5), Eigen::VectorXd::Ones(2)});
  for (const Offsets& frame : Calmed(frames, 2)) {
    EXPECT_LT((frame.local.array() - 0.5).abs().maxCoeff(), 1e-12);
    EXPECT_NEAR(frame.sure[0], 1, 1e-12);
  }
  frames[4].local.row(1).setConstant(7), frames[4].sure[1] = 0;  // hidden, and wrong there
  const std::vector<Offsets> calmed = Calmed(frames, 0);
  EXPECT_NEAR(calmed[4].local(0, 0), 0.5, 1e-9);
  EXPECT_NEAR(calmed[4].local(1, 0), 0.5, 0.1);
  EXPECT_EQ(calmed[4].sure[1], 0);
}

TEST(Calmed, TakesAwayTheNoiseOfSingleFrames) {
  std::vector<Offsets> frames;
  for (int f = 0; f < 40; ++f)
    frames.push_back({PointsX3::Constant(1, 3, f % 2 ? 1.0 : -1.0), Eigen::VectorXd::Ones(1)});
  for (const Offsets& frame : Calmed(frames, 1.5)) EXPECT_LT(std::abs(frame.local(0, 0)), 0.3);
  EXPECT_TRUE(Calmed({}, 1).empty());
}

}  // namespace keypose::fit::calm_test
