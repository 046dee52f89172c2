#include "reconstruct/matching/verification.h"

#include <gtest/gtest.h>

#include <random>

#include "core/values/size_of.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::verification_test {

using Eigen::Vector2d;
using testing::BallCamera;
using testing::PointsOnBall;

TEST(VerifyPair, InliersOfARigidSceneAreFoundAmongWrongMatchesAndChanceIsNot) {
  const Scene scene = PointsOnBall({BallCamera(0, 18), BallCamera(1, 18)}, 400, 0);
  std::mt19937 random(4);
  std::uniform_real_distribution<float> anywhere(0, 240);
  Features first, second;
  const auto right = SizeOf(scene.points), wrong = right;
  for (Features* features : {&first, &second}) {
    features->positions.resize(right + wrong, 2);
    features->scales.setOnes(right + wrong);
    for (int i = 0; i < right + wrong; ++i) {
      const Vector2d pixel =
          i < right ? scene.views[features == &first ? 0 : 1].Project(scene.points[i].position)
                    : Vector2d(anywhere(random), anywhere(random));
      features->positions.row(i) = pixel.cast<float>().transpose();
    }
  }
  PairMatches raw{0, 1, {}}, chance{0, 1, {}};
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(right + wrong); ++i)
    raw.features.emplace_back(i, i);
  for (std::uint32_t i = 0; i < static_cast<std::uint32_t>(std::min(wrong, 60)); ++i)
    chance.features.emplace_back(static_cast<std::uint32_t>(right) + i,
                                 static_cast<std::uint32_t>(right) + i);
  VerificationOptions options;
  options.max_error_px = 1;
  const auto verified = VerifyPair(first, second, raw, options);
  ASSERT_TRUE(verified.has_value());
  int found = 0;
  for (const auto& [i, j] : verified->inliers.features)
    found += static_cast<int>(i) < right ? 1 : 0;
  EXPECT_GT(found, 0.95 * right);
  EXPECT_LT(SizeOf(verified->inliers.features) - found, 0.1 * wrong);
  EXPECT_FALSE(VerifyPair(first, second, chance, options).has_value());
  EXPECT_FALSE(VerifyPair(first, second, PairMatches{0, 1, {{0, 0}}}, options).has_value());
}

}  // namespace keypose::reconstruct::verification_test
