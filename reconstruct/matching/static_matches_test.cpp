#include <gtest/gtest.h>

#include <random>

#include "reconstruct/matching/static_matches.h"

namespace keypose::reconstruct::static_matches_test {

/// `count` matches of feature i with feature i, displaced by up to `reach` px along each axis.
struct Pair {
  Features first, second;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> matches;
};

void Add(Pair& pair, int count, double reach, double shift, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  const Eigen::Index old = pair.first.positions.rows();
  pair.first.positions.conservativeResize(old + count, 2);
  pair.second.positions.conservativeResize(old + count, 2);
  for (Eigen::Index i = old; i < old + count; ++i) {
    const Eigen::Vector2d at(500 + 400 * uniform(random), 400 + 300 * uniform(random));
    const Eigen::Vector2d by(shift + reach * uniform(random), reach * uniform(random));
    pair.first.positions.row(i) = at.transpose().cast<float>();
    pair.second.positions.row(i) = (at + by).transpose().cast<float>();
    pair.matches.emplace_back(static_cast<std::uint32_t>(i), static_cast<std::uint32_t>(i));
  }
}

TEST(RejectStaticMatches, TakesTheBackgroundAndLeavesWhatTurns) {
  std::mt19937 random(3);
  Pair pair;
  Add(pair, 120, 40, 20, random);
  Add(pair, 300, 0.4, 0, random);
  EXPECT_EQ(RejectStaticMatches(pair.first, pair.second, 1000, pair.matches), 300);
  EXPECT_EQ(pair.matches.size(), 120U);
}

TEST(RejectStaticMatches, LeavesSmallTurnsNearTheAxis) {
  std::mt19937 random(4);
  Pair pair;
  Add(pair, 900, 5, 0, random);  // some 30 within 1 px, but no excess
  EXPECT_EQ(RejectStaticMatches(pair.first, pair.second, 1000, pair.matches), 0);
  EXPECT_EQ(pair.matches.size(), 900U);
}

TEST(RejectStaticMatches, SevenAreNoBackground) {
  std::mt19937 random(5);
  Pair pair;
  Add(pair, 7, 0.3, 0, random);
  EXPECT_EQ(RejectStaticMatches(pair.first, pair.second, 1000, pair.matches), 0);
}

}  // namespace keypose::reconstruct::static_matches_test
