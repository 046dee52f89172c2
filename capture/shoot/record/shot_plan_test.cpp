#include "capture/shoot/record/shot_plan.h"

#include <gtest/gtest.h>

#include <set>

namespace keypose::capture::shoot::plan_test {

TEST(ShotPlan, NamesEveryShotOnceAndFindsItAgain) {
  for (const int angles : {3, 24, 32, 100, 360}) {
    const ShotPlan plan{.rings_deg = {12, 40}, .angles = angles, .flips = 2};
    std::set<std::string> names;
    for (const Shot& shot : AllShots(plan)) {
      names.insert(NameOf(plan, shot));
      EXPECT_EQ(ShotNamed(plan, NameOf(plan, shot)), shot);
    }
    EXPECT_EQ(names.size(), 3u * 2 * angles);
  }
}

TEST(ShotPlan, NamesRingAngleAndFlip) {
  const ShotPlan plan{.rings_deg = {12, 40}, .angles = 32, .flips = 2};
  EXPECT_EQ(NameOf(plan, {0, 1, 0}), "r1_a000");
  EXPECT_EQ(NameOf(plan, {1, 2, 1}), "lying_r2_a011");  // 11.25 degrees
  EXPECT_EQ(NameOf(plan, {2, 1, 31}), "lying2_r1_a349");
  EXPECT_DOUBLE_EQ(AngleOf(plan, {1, 2, 1}), 11.25);
  EXPECT_DOUBLE_EQ(TiltOf(plan, {1, 2, 1}), 40);
}

TEST(ShotAt, FindsTheAngleWithinHalfADegreeRoundTheCircle) {
  const ShotPlan plan;
  EXPECT_EQ(ShotAt(plan, 0, 1, 45.4), (Shot{0, 1, 3}));
  EXPECT_EQ(ShotAt(plan, 0, 2, -15), (Shot{0, 2, 23}));
  EXPECT_EQ(ShotAt(plan, 0, 1, 359.8), (Shot{0, 1, 0}));
  EXPECT_FALSE(ShotAt(plan, 0, 1, 17));
  EXPECT_FALSE(ShotAt(plan, 0, 3, 45));
  EXPECT_FALSE(ShotAt(plan, 1, 1, 45));
  EXPECT_FALSE(ShotAt(plan, 0, 1, 1e300));
}

TEST(ShotPlan, SaysWhichFlagIsOutOfRange) {
  const auto problem = [](const ShotPlan& plan) {
    const auto problems = plan.Problems();
    return problems.empty() ? "" : problems.front();
  };
  EXPECT_EQ(problem({}), "");
  EXPECT_NE(problem({.rings_deg = {}}).find("--rings"), std::string::npos);
  EXPECT_NE(problem({.rings_deg = {12, 95}}).find("95"), std::string::npos);
  EXPECT_NE(problem({.angles = 361}).find("--angles"), std::string::npos);
  EXPECT_NE(problem({.flips = 4}).find("--flips"), std::string::npos);
  EXPECT_NE(problem({.focus_stack = 0}).find("--focus-stack"), std::string::npos);
}

TEST(DegreesText, HasNoZerosAtTheEnd) {
  EXPECT_EQ(DegreesText(45), "45");
  EXPECT_EQ(DegreesText(100), "100");
  EXPECT_EQ(DegreesText(22.5), "22.5");
  EXPECT_EQ(DegreesText(11.25), "11.25");
}

}  // namespace keypose::capture::shoot::plan_test
