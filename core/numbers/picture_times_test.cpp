#include "core/numbers/picture_times.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace keypose::picture_times_test {

std::vector<double> Even(int count, double rate) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) times.push_back(i / rate);
  return times;
}

TEST(RateOf, AHeaderThatTheTimesConfirmIsTakenExactly) {
  std::vector<double> milliseconds = Even(300, 30 / 1.001);
  for (double& time : milliseconds) time = std::round(time * 1000) / 1000;
  const PictureRate rate = RateOf(milliseconds, 30 / 1.001);
  EXPECT_EQ(rate.per_second, 30 / 1.001);
  EXPECT_TRUE(rate.constant);
}

TEST(RateOf, AHeaderThatTheTimesDenyIsNot) {
  const PictureRate rate = RateOf(Even(100, 24), 30);
  EXPECT_NEAR(rate.per_second, 24, 1e-9);
  EXPECT_TRUE(rate.constant);
}

TEST(RateOf, MissingPicturesDoNotSlowTheRate) {
  std::vector<double> times = Even(120, 30);
  for (const int lost : {100, 61, 60, 59, 40, 12, 10}) times.erase(times.begin() + lost);
  const PictureRate rate = RateOf(times, 28.25);
  EXPECT_FALSE(rate.constant);
  EXPECT_NEAR(rate.per_second, 30, 1e-9);
  std::vector<int> expected(120);
  std::iota(expected.begin(), expected.end(), 0);
  for (const int lost : {100, 61, 60, 59, 40, 12, 10}) expected.erase(expected.begin() + lost);
  EXPECT_EQ(FrameNumbers(times, rate), expected);
}

TEST(RateOf, OnePictureAloneHasTheHeadersRate) {
  EXPECT_EQ(RateOf({3.0}, 25).per_second, 25);
  EXPECT_EQ(RateOf({}, 0).per_second, 0);
}

TEST(FrameNumbers, TwoInOneFrameStayTwo) {
  EXPECT_EQ(FrameNumbers({0, 0.1, 0.12, 0.5}, {10, false}), (std::vector<int>{0, 1, 2, 5}));
}

}  // namespace keypose::picture_times_test
