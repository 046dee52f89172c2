#include "reconstruct/matching/descriptor_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/values/angles.h"
#include "reconstruct/matching/testing/random_features.h"

namespace keypose::reconstruct::descriptor_matching_test {

/// The same search in floating point, pair by pair.
std::vector<std::pair<std::uint32_t, std::uint32_t>> MatchByDefinition(
    const Features& a, const Features& b, const MatchOptions& options) {
  Eigen::MatrixXd angles(a.count(), b.count());
  for (int i = 0; i < a.count(); ++i)
    for (int j = 0; j < b.count(); ++j) {
      double dot = 0;
      for (int k = 0; k < 128; ++k)
        dot += static_cast<double>(a.descriptors[static_cast<std::size_t>(i) * 128 + k]) *
               b.descriptors[static_cast<std::size_t>(j) * 128 + k];
      angles(i, j) = std::acos(std::min(1.0, dot / (512.0 * 512.0)));
    }
  const auto best = [&](const Eigen::VectorXd& row) {
    int at = 0;
    const double nearest = row.minCoeff(&at);
    double second = kPi / 2;
    for (int j = 0; j < row.size(); ++j)
      if (j != at) second = std::min(second, row(j));
    return nearest <= options.max_distance && nearest < options.max_ratio * second ? at : -1;
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
  for (int i = 0; i < a.count(); ++i)
    if (const int j = best(angles.row(i)); j >= 0 && best(angles.col(j)) == i)
      matches.emplace_back(i, j);
  return matches;
}

TEST(MatchDescriptors, FindsAPermutationExactly) {
  std::mt19937 random(5);
  const Features a = RandomFeatures(203, random);
  const auto order = Shuffled(203, random);
  const auto matches = MatchDescriptors(a, Permuted(a, order), {});
  ASSERT_EQ(matches.size(), 203U);
  for (const auto& [i, j] : matches) EXPECT_EQ(static_cast<int>(i), order[j]);
}

TEST(MatchDescriptors, AgreesWithTheDefinitionOnNoisyDescriptors) {
  std::mt19937 random(6);
  const Features a = RandomFeatures(151, random);
  Features b = Permuted(a, Shuffled(151, random));
  std::normal_distribution<double> noise(0, 14);
  for (std::int16_t& d : b.descriptors)
    d = static_cast<std::int16_t>(std::clamp(d + noise(random), 0.0, 255.0));
  const MatchOptions options;
  const auto expected = MatchByDefinition(a, b, options);
  EXPECT_GT(expected.size(), 20U);
  EXPECT_EQ(MatchDescriptors(a, b, options), expected);
}

TEST(MatchDescriptors, NoFeaturesGiveNoMatches) {
  std::mt19937 random(7);
  EXPECT_TRUE(MatchDescriptors(Features{}, RandomFeatures(5, random), {}).empty());
  EXPECT_TRUE(MatchDescriptors(RandomFeatures(5, random), Features{}, {}).empty());
}

TEST(LargestFeatures, KeepsTheLargestInTheirOrder) {
  std::mt19937 random(8);
  Features features = RandomFeatures(4, random);
  features.scales << 2, 9, 1, 5;
  EXPECT_EQ(LargestFeatures(features, 2).scales, Eigen::Vector2f(9, 5));
}

}  // namespace keypose::reconstruct::descriptor_matching_test
