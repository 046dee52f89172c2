#include "core/numbers/statistics.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

namespace keypose::statistics_test {

const std::vector<double> kNone, kOne{7}, kThree{3, 1, 2}, kFour{4, 1, 3, 2};

TEST(UpperMedian, IsTheMiddleOfAnOddNumber) { EXPECT_EQ(UpperMedian(kThree), 2); }

TEST(UpperMedian, IsTheUpperMiddleOfAnEvenNumber) { EXPECT_EQ(UpperMedian(kFour), 3); }

TEST(UpperMedian, TakesAnyContainerOfNumbers) {
  EXPECT_EQ(UpperMedian(std::array<std::uint8_t, 3>{200, 100, 255}), 200);
  EXPECT_EQ(UpperMedian(Eigen::VectorXd(Eigen::Vector4d(4, 1, 3, 2))), 3);
  EXPECT_EQ(UpperMedian(std::vector<float>{0.5f, 0.25f, 1}), 0.5f);
}

TEST(UpperMedian, OfACopyLeavesTheOrder) {
  std::vector<double> values = kFour;
  UpperMedian(values);
  EXPECT_EQ(values, kFour);
}

TEST(UpperMedian, InPlaceKeepsTheValues) {
  std::vector<double> values = kFour;
  EXPECT_EQ(UpperMedianInPlace(values), 3);
  EXPECT_EQ(values[2], 3);
  std::sort(values.begin(), values.end());
  EXPECT_EQ(values, (std::vector<double>{1, 2, 3, 4}));
}

TEST(Quantiles, RoundAsTheirNamesSay) {
  // Shares of the places 0..3 and of the number 4.
  EXPECT_EQ(QuantileFloor(kFour, 0.6), 2);    // place 1.8
  EXPECT_EQ(QuantileNearest(kFour, 0.6), 3);  // place 1.8
  EXPECT_EQ(QuantileAbove(kFour, 0.6), 3);    // place 2.4
  EXPECT_EQ(QuantileFloor(kFour, 0.4), 2);    // place 1.2
  EXPECT_EQ(QuantileNearest(kFour, 0.4), 2);  // place 1.2
  EXPECT_EQ(QuantileNearest(kFour, 0.5), 3);  // place 1.5
  EXPECT_EQ(QuantileAbove(kFour, 0.2), 1);    // place 0.8
}

TEST(Quantiles, OfShares0And1AreLeastAndGreatest) {
  EXPECT_EQ(QuantileFloor(kFour, 0), 1);
  EXPECT_EQ(QuantileNearest(kFour, 0), 1);
  EXPECT_EQ(QuantileAbove(kFour, 0), 1);
  EXPECT_EQ(QuantileFloor(kFour, 1), 4);
  EXPECT_EQ(QuantileNearest(kFour, 1), 4);
  EXPECT_EQ(QuantileAbove(kFour, 1), 4);
}

TEST(Quantiles, OfWholePercentsAreAtTheWholePlace) {
  // A percent has no exact double; the products must not fall below the whole number.
  std::vector<int> values(1000);
  for (int i = 0; i < 1000; ++i) values[i] = i;
  for (int percent = 0; percent < 100; ++percent)
    EXPECT_EQ(QuantileAbove(values, percent / 100.0), 10 * percent);
}

TEST(TrimmedRange, LeavesOutTheSameNumberAtEachEnd) {
  std::vector<double> values;
  for (int i = 0; i < 25; ++i) values.push_back((7 * i) % 25);
  EXPECT_EQ(TrimmedRange(values, 0.1), std::pair(2.0, 22.0));  // 2.5 values
  EXPECT_EQ(TrimmedRange(values, 0), std::pair(0.0, 24.0));
}

TEST(Statistics, OfOneValueAreThatValue) {
  EXPECT_EQ(UpperMedian(kOne), 7);
  EXPECT_EQ(QuantileFloor(kOne, 0.9), 7);
  EXPECT_EQ(QuantileNearest(kOne, 0.9), 7);
  EXPECT_EQ(QuantileAbove(kOne, 0.9), 7);
  EXPECT_EQ(TrimmedRange(kOne, 0.4), std::pair(7.0, 7.0));
}

TEST(Statistics, OfNoValuesAreZero) {
  EXPECT_EQ(UpperMedian(kNone), 0);
  EXPECT_EQ(QuantileFloor(kNone, 0.5), 0);
  EXPECT_EQ(QuantileNearest(kNone, 0.5), 0);
  EXPECT_EQ(QuantileAbove(kNone, 0.5), 0);
  EXPECT_EQ(TrimmedRange(kNone, 0.1), std::pair(0.0, 0.0));
}

}  // namespace keypose::statistics_test
