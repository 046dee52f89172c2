#include "views/hull/silhouettes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/pictures/fit_view.h"

namespace keypose::silhouettes_test {

constexpr double kPixels = 75;  // radius of the ball in the pictures, approximately

// Exact masks of the unit ball from a ring of cameras, so far away that they are nearly
// orthographic.
std::vector<PreparedView> BallRing(int count, double elevation_deg = 0, double distance = 50) {
  std::vector<PreparedView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 2 * M_PI * i / count, elevation = elevation_deg * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera = {.width = 200,
                   .height = 200,
                   .fx = kPixels * distance,
                   .fy = kPixels * distance,
                   .cx = 100.3,
                   .cy = 99.6};
    view.camera_from_world = LookAt(
        distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                   std::sin(azimuth) * std::cos(elevation), std::sin(elevation)),
        Eigen::Vector3d::Zero());
    const double radius = view.camera.fx / std::sqrt(distance * distance - 1);
    Image8 mask(200, 200, 1);
    for (int y = 0; y < 200; ++y)
      for (int x = 0; x < 200; ++x)
        if (std::hypot(x + 0.5 - view.camera.cx, y + 0.5 - view.camera.cy) <= radius)
          *mask.at(x, y) = 255;
    views.push_back(PrepareView(view, i, Image8(200, 200, 3, 128), mask, 1.0, 2));
  }
  return views;
}

VisualHull Carved(const std::vector<PreparedView>& views, int votes = 1) {
  VisualHullOptions options;
  options.resolution = 96;
  options.outside_votes = votes;
  return CarveVisualHull(views, options);
}

TEST(Silhouettes, SliceOfARingIsThePolygonOfItsOutlines) {
  // n views of a circle give a regular polygon around it, of n sides when n is even, of 2 n when it
  // is odd.
  for (const int n : {4, 5, 8, 12}) {
    const Silhouettes silhouettes(BallRing(n, 0, 1000), 1);
    const int sides = n % 2 ? 2 * n : n;
    double area = 0;
    constexpr int kSteps = 720;
    for (int k = 0; k < kSteps; ++k) {
      const double angle = 2 * M_PI * (k + 0.5) / kSteps;
      double inner = 0.5, outer = 2;
      for (int h = 0; h < 20; ++h) {
        const double middle = 0.5 * (inner + outer);
        (silhouettes.Outside({middle * std::cos(angle), middle * std::sin(angle), 0}) <= 0
             ? inner
             : outer) = middle;
      }
      area += inner * inner * M_PI / kSteps;
    }
    // Pixels are classified by their centres: the outline is accurate to a fraction of one, 1/75 of
    // the radius.
    EXPECT_NEAR(area / M_PI, sides / M_PI * std::tan(M_PI / sides), 0.015) << n << " views";
  }
}

TEST(Silhouettes, VotesForgiveAsManyViewsLessOne) {
  const std::vector<PreparedView> views = BallRing(12);
  const Eigen::Vector3d beside(0, 1.08, 0);  // outside for the views along x and their neighbours
  EXPECT_GT(Silhouettes(views, 1).Outside(beside), 4);
  EXPECT_LT(Silhouettes(views, 8).Outside(beside), 0);
  EXPECT_FALSE(Silhouettes(views, 1).Within(beside, 1));
  EXPECT_TRUE(Silhouettes(views, 8).Within(beside, 1));
}

TEST(Silhouettes, OutlineNormalPointsOutOfTheBall) {
  const std::vector<PreparedView> views = BallRing(4);
  const Silhouettes silhouettes(views, 1);
  for (int k = 0; k < 12; ++k) {
    const double angle = k * M_PI / 6;
    const Eigen::Vector3d x(0, std::cos(angle),
                            std::sin(angle));  // on the outline of the view along x
    EXPECT_GT(silhouettes.OutlineNormal(0, x).dot(x), 0.99);
    EXPECT_NEAR(silhouettes.See(0, x).distance, 0, 0.6);
    EXPECT_NEAR(silhouettes.See(0, x).footprint * kPixels, 1, 0.01);
  }
}

TEST(ExactHullSurface, LiesOnTheOutlinesWhateverTheGrid) {
  const std::vector<PreparedView> views = BallRing(16, 15);
  const Silhouettes silhouettes(views, 1);
  const PointCloud surface = ExactHullSurface(Carved(views), silhouettes);
  ASSERT_GT(surface.points.rows(), 5000);
  for (int i = 0; i < surface.points.rows(); ++i)
    ASSERT_NEAR(silhouettes.Outside(surface.points.row(i)), 0, 0.1);
}

TEST(CheckAgainstHull, NamesTheViewWhosePrincipalPointIsWrong) {
  std::vector<PreparedView> views = BallRing(14, 20);
  const HullCheck good = CheckAgainstHull(views, Carved(views), Silhouettes(views, 1));
  EXPECT_GT(good.mean, 0.985);
  EXPECT_TRUE(good.disagreeing.empty());
  for (PreparedView::Level& level : views[5].levels)
    level.camera.cx += 8.0 * level.camera.fx / views[5].levels[0].camera.fx;
  const HullCheck bad = CheckAgainstHull(views, Carved(views, 2), Silhouettes(views, 2));
  ASSERT_FALSE(bad.disagreeing.empty());
  EXPECT_LE(bad.disagreeing.size(), 2u);
  EXPECT_EQ(std::count(bad.disagreeing.begin(), bad.disagreeing.end(), "v5"), 1);
  for (int i = 0; i < 14; ++i) {
    if (i == 5) continue;
    EXPECT_GT(bad.iou[i], bad.iou[5] + 0.03) << views[i].name;
  }
}

}  // namespace keypose::silhouettes_test
