#include "fit/contours/outline.h"

#include <gtest/gtest.h>

#include "fit/contours/testing/disc_view.h"

namespace keypose::fit::outline_test {

TEST(Outline, HasTheDiscsDistancesAndNormals) {
  const Outline outline = MakeOutline(DiscView(60), 0);
  EXPECT_NEAR(outline.Distance({kMiddle + 70, kMiddle}), 10, 0.6);
  EXPECT_NEAR(outline.Distance({kMiddle, kMiddle - 40}), -20, 0.6);
  EXPECT_GT(outline.Gradient({kMiddle + 55, kMiddle}).x(), 0.99);
  ASSERT_GT(outline.points.size(), 100u);
  for (const Outline::Point& point : outline.points) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d::Constant(kMiddle);
    EXPECT_NEAR(from.norm(), 60, 0.8);
    EXPECT_GT(point.normal.dot(from.normalized()), 0.9);
  }
}

TEST(OutlineMatches, PullASmallSphereOutFromBothSides) {
  const PreparedView view = DiscView(60);
  const Outline outline = MakeOutline(view, 0);
  const std::vector<ContourPoint> contour = SphereSilhouette(view);
  const double gap = 60 - SphereRadius();
  const auto to = MatchToOutline(contour, outline, 30),
             from = MatchFromOutline(contour, outline, 30);
  EXPECT_EQ(to.size(), contour.size());
  EXPECT_GT(from.size(), outline.points.size() * 9 / 10);
  for (const auto& matches : {to, from})
    for (const OutlineMatch& match : matches) {
      EXPECT_NEAR(match.distance_px, gap, 0.9);
      EXPECT_GT(match.direction.dot(contour[match.contour].normal), 0.5);
    }
  EXPECT_TRUE(MatchToOutline(contour, outline, gap / 2).empty());
}

}  // namespace keypose::fit::outline_test
