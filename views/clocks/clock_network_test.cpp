#include "views/clocks/clock_network.h"

#include <gtest/gtest.h>

namespace keypose::clock_network_test {

ClockLink Link(int a, int b, double offset_s) {
  ClockLink link{a, b, {}};
  link.drift.whole.seconds = offset_s;
  link.drift.whole.confident = true;
  link.drift.whole.middle_s = 5;
  return link;
}

/// With an offset that changes over a minute.
ClockLink Drifting(int a, int b, double first_s, double last_s) {
  ClockLink link = Link(a, b, 0.5 * (first_s + last_s));
  link.drift.measured = true;
  link.drift.first_s = first_s, link.drift.last_s = last_s;
  link.drift.first_at_s = 10, link.drift.last_at_s = 70;
  return link;
}

TEST(LinkedGroups, AreNumberedInTheFilmsOrder) {
  EXPECT_EQ(LinkedGroups(5, {Link(3, 1, 0), Link(1, 4, 0)}), (std::vector<int>{0, 1, 2, 1, 1}));
  EXPECT_EQ(LinkedGroups(2, {}), (std::vector<int>{0, 1}));
}

TEST(ConfirmedByThird, NeedsTwoOthersThatSayTheSame) {
  const std::vector<ClockLink> links{Link(0, 1, 1), Link(1, 2, 2), Link(0, 2, 3.01), Link(1, 3, 1),
                                     Link(2, 3, 1)};
  EXPECT_EQ(ConfirmedByThird(links, 0.03), (std::vector<bool>{true, true, true, false, false}));
}

TEST(SolveClocks, FilmsThatBeganLaterHaveLaterBegins) {
  // film 1 began 2 s after film 0, film 2 half a second before it
  const ClockNetwork found = SolveClocks(3, {Link(0, 1, -2), Link(1, 2, 2.5)}, 0.02);
  EXPECT_NEAR(found.clocks[0].begin_s, 0.5, 1e-6);
  EXPECT_NEAR(found.clocks[1].begin_s, 2.5, 1e-6);
  EXPECT_NEAR(found.clocks[2].begin_s, 0, 1e-6);
  EXPECT_LT(found.worst_s, 1e-6);
  for (const FilmClock& clock : found.clocks) EXPECT_EQ(clock.rate, 1);
}

TEST(SolveClocks, AContradictionIsSharedAndSaid) {
  const ClockNetwork found =
      SolveClocks(3, {Link(0, 1, -1), Link(1, 2, -1), Link(0, 2, -2.3)}, 0.02);
  EXPECT_NEAR(found.clocks[1].begin_s, 1.1, 1e-4);
  EXPECT_NEAR(found.clocks[2].begin_s, 2.2, 1e-4);
  EXPECT_NEAR(found.worst_s, 0.1, 1e-4);
}

TEST(SolveClocks, AClockThatRunsFasterGetsARate) {
  const ClockNetwork small = SolveClocks(2, {Drifting(0, 1, -2, -1.99)}, 0.02);
  EXPECT_EQ(small.clocks[1].rate, 1);
  const ClockNetwork found = SolveClocks(2, {Drifting(0, 1, -2, -1.94)}, 0.02);
  // 0.06 s in a minute; at both ends the clocks agree
  EXPECT_NEAR(found.clocks[1].rate, 1 / 1.001, 1e-8);
  for (const auto& [a, b] : {std::pair(10.0, 8.0), std::pair(70.0, 68.06)})
    EXPECT_NEAR(found.clocks[0].begin_s + a, found.clocks[1].begin_s + found.clocks[1].rate * b,
                2e-5);
}

}  // namespace keypose::clock_network_test
