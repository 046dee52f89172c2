#include "reconstruct/matching/guided_matching.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "reconstruct/matching/descriptor_matching.h"
#include "reconstruct/matching/testing/random_features.h"

namespace keypose::reconstruct::guided_matching_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::ElementsAre;

/// Two images with a baseline along x, so that epipolar lines are rows.
PairGeometry RowGeometry() {
  PairGeometry geometry;
  geometry.kind = PairGeometry::kFundamental;
  geometry.matrix << 0, 0, 0, 0, 0, -1, 0, 1, 0;
  return geometry;
}

TEST(MatchGuided, FindsOnTheLineWhatARivalElsewhereHides) {
  std::mt19937 random(9);
  Features a = RandomFeatures(1, random);
  a.positions.row(0) << 100, 200;
  // twice the same descriptor: the ratio test alone must reject it
  Features b = Permuted(a, {0, 0});
  b.positions.row(0) << 300, 201;
  b.positions.row(1) << 300, 260;
  EXPECT_TRUE(MatchDescriptors(a, b, {}).empty());
  EXPECT_THAT(MatchGuided(a, b, RowGeometry(), {}, 4),
              ElementsAre(std::pair<std::uint32_t, std::uint32_t>(0, 0)));
}

TEST(MatchGuided, TriesExactlyTheFeaturesWithinTheError) {
  std::mt19937 random(10);
  const Features a = RandomFeatures(300, random);
  Features b = Permuted(a, Shuffled(300, random));
  PairGeometry geometry;
  geometry.kind = PairGeometry::kFundamental;
  geometry.matrix << 1e-7, -3e-6, 2e-3, 2.6e-6, 2e-7, -2.2e-2, -2.4e-3, 2.1e-2, 1.1;
  const auto matches = MatchGuided(a, b, geometry, {.max_ratio = 1, .max_distance = 1.5}, 4);
  for (const auto& [i, j] : matches) {
    const Vector3d x = a.positions.row(i).transpose().cast<double>().homogeneous(),
                   y = b.positions.row(j).transpose().cast<double>().homogeneous();
    const Vector3d line = geometry.matrix * x;
    const double e2 = std::pow(y.dot(line), 2);
    EXPECT_LE(e2, 16 * (line.head<2>().squaredNorm() +
                        (geometry.matrix.transpose() * y).head<2>().squaredNorm()));
  }
  EXPECT_GT(matches.size(), 10U);
}

TEST(MatchGuided, GridMissesNothingNearSteepAndFlatLines) {
  std::mt19937 random(11);
  const Features a = RandomFeatures(120, random);
  for (const double angle : {0.0, 0.4, 0.8, 1.2, 1.57}) {
    // Features shifted along a direction: the geometry of a sideways camera, rotated.
    const Vector2d along(std::cos(angle), std::sin(angle));
    Features b = a;
    for (int i = 0; i < b.count(); ++i)
      b.positions.row(i) += (30 + i % 50) * along.cast<float>().transpose();
    PairGeometry geometry;
    geometry.kind = PairGeometry::kFundamental;
    geometry.matrix << 0, 0, along.y(), 0, 0, -along.x(), -along.y(), along.x(), 0;
    EXPECT_EQ(MatchGuided(a, b, geometry, {}, 4).size(), 120U) << angle;
  }
}

TEST(MatchGuided, HomographyLooksAroundTheTarget) {
  std::mt19937 random(12);
  Features a = RandomFeatures(1, random);
  a.positions.row(0) << 100, 100;
  Features b = Permuted(a, {0, 0});
  b.positions.row(0) << 110, 106;  // 1 px off the shifted position
  b.positions.row(1) << 140, 105;
  PairGeometry geometry;
  geometry.kind = PairGeometry::kHomography;
  geometry.matrix << 1, 0, 10, 0, 1, 5, 0, 0, 1;
  EXPECT_THAT(MatchGuided(a, b, geometry, {}, 4),
              ElementsAre(std::pair<std::uint32_t, std::uint32_t>(0, 0)));
}

}  // namespace keypose::reconstruct::guided_matching_test
