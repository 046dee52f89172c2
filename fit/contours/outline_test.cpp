#include "fit/contours/outline.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "fit/contours/disagreement.h"

namespace keypose::fit::outline_test {

constexpr int kSize = 201;
constexpr double kMiddle = 100;

/// A view whose mask is a disc around the picture's middle.
PreparedView DiscView(double radius_px) {
  PreparedView view;
  PreparedView::Level level;
  level.camera = {kSize, kSize, 400, 400, kMiddle, kMiddle};
  level.grey = GreyMask(kSize, kSize, 1);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      *level.grey.at(x, y) = std::hypot(x - kMiddle, y - kMiddle) <= radius_px ? 1 : 0;
  view.levels.push_back(level);
  view.camera_from_world = LookAt({0, -8, 0}, {0, 0, 0});
  return view;
}

/// Radius in pixels of the unit sphere's outline at a distance of 8.
double SphereRadius() { return 400 / std::sqrt(8.0 * 8 - 1); }

std::vector<ContourPoint> SphereSilhouette(const PreparedView& view) {
  const Mesh sphere = MakeIcosphere(5);
  return FindSilhouette(sphere.points, sphere.faces, FindFacePairs(sphere.faces),
                        RayScene(sphere.points, sphere.faces), view.camera(),
                        view.camera_from_world);
}

TEST(FindSilhouette, OfASphereIsTheWholeCircleWithNormalsOutwards) {
  const std::vector<ContourPoint> contour = SphereSilhouette(DiscView(50));
  double length = 0;
  for (const ContourPoint& point : contour) {
    const Eigen::Vector2d from = point.pixel - Eigen::Vector2d::Constant(kMiddle);
    EXPECT_NEAR(from.norm(), SphereRadius(), 0.3);
    EXPECT_GT(point.normal.dot(from.normalized()), 0.5);
    length += point.length_px;
  }
  // A polyhedron's outline zigzags a little about the circle.
  EXPECT_NEAR(length, 2 * std::numbers::pi * SphereRadius(), 0.15 * length);
}

TEST(FindSilhouette, LeavesOutContoursBeforeTheSurfaceItself) {
  Mesh two = MakeIcosphere(4);
  const Mesh front = two;
  const int count = two.vertex_count();
  two.points.conservativeResize(2 * count, 3);
  two.points.bottomRows(count) = 0.3 * front.points;
  two.points.bottomRows(count).col(1).array() -= 3;  // a small sphere before the large one
  two.faces.conservativeResize(2 * front.face_count(), 3);
  two.faces.bottomRows(front.face_count()) = front.faces.array() + count;
  const PreparedView view = DiscView(50);
  for (const ContourPoint& point :
       FindSilhouette(two.points, two.faces, FindFacePairs(two.faces),
                      RayScene(two.points, two.faces), view.camera(), view.camera_from_world))
    EXPECT_LT(point.a, count);
}

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

TEST(WorstDisagreement, IsWhereTheOneIsBeyondTheOther) {
  const double radius = SphereRadius();
  for (const double mask : {60.0, 40.0}) {
    PreparedView view = DiscView(mask);
    const Disagreement found = WorstDisagreement(SphereSilhouette(view), MakeOutline(view, 0));
    EXPECT_NEAR(found.distance_px, std::abs(mask - radius), 1);
    EXPECT_EQ(found.mask_beyond, mask > radius);
    const double from_middle = (found.pixel - Eigen::Vector2d::Constant(kMiddle)).norm();
    EXPECT_NEAR(from_middle, std::max(mask, radius), 1);
  }
}

TEST(WorstDisagreement, ASpurOfTheMaskIsFound) {
  PreparedView view = DiscView(SphereRadius());
  for (int x = 100; x < 190; ++x)
    for (int y = 96; y < 104; ++y) *view.levels[0].grey.at(x, y) = 1;
  const Disagreement found = WorstDisagreement(SphereSilhouette(view), MakeOutline(view, 0));
  EXPECT_TRUE(found.mask_beyond);
  EXPECT_NEAR(found.pixel.x(), 189, 2);
  EXPECT_NEAR(found.distance_px, 189 - kMiddle - SphereRadius(), 2);
  EXPECT_EQ(WorstDisagreement({}, MakeOutline(view, 0)).distance_px, 0);
}

}  // namespace keypose::fit::outline_test
