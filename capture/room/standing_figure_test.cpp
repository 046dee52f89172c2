#include "capture/room/standing_figure.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "capture/room/coarse_depths.h"
#include "capture/room/testing/figure_on_book.h"

namespace keypose::capture::standing_figure_test {

using Eigen::Vector3d;

TEST_F(StandingFigureTest, StandsOnTheBookAndNotTheTable) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  EXPECT_GT(standing->support.up.z(), 0.9999);
  EXPECT_NEAR(standing->support.height, kBookTop, 0.002);
  EXPECT_NEAR(standing->height, kFigureTop - kBookTop, 0.03) << "the lid is seen at a slant";
  int figure = 0, box = 0, wrong = 0;
  for (std::size_t v = 0; v < Depths().views.size(); ++v)
    for (std::size_t k = 0; k < Depths().views[v].size(); ++k) {
      const DepthSample& sample = Depths().views[v][k];
      const auto thing = *World().things[v].at(static_cast<int>(sample.pixel.x()),
                                               static_cast<int>(sample.pixel.y()));
      const bool is_figure = standing->samples[v][k] == SampleLabel::kFigure;
      figure += is_figure;
      box += thing == kBox && standing->samples[v][k] == SampleLabel::kOther;
      wrong += is_figure != (thing == kFigure) && standing->samples[v][k] != SampleLabel::kOpen;
    }
  EXPECT_GT(figure, 10000);
  EXPECT_GT(box, 2000);
  EXPECT_LT(wrong, 0.15 * figure) << "windows widen the figure by a pixel or two";
}

TEST_F(StandingFigureTest, ALineOverAPartOfItTakesThatPartAway) {
  // Lines on the upper half say that it is not the figure; clicks below say what is.
  Opinions opinions;
  for (const View& view : World().scene.views) {
    const auto pixel = [&view](const Vector3d& x) -> Eigen::Vector2i {
      return view.Project(x).array().floor().cast<int>();
    };
    const Vector3d front =
        kFigureRadius * Vector3d(view.Center().x(), view.Center().y(), 0).normalized();
    opinions.strokes.emplace_back();
    opinions.strokes.back().figure = {pixel(front + Vector3d(0, 0, 0.1))};
    for (int k = 0; k < 20; ++k)
      opinions.strokes.back().other.push_back(pixel(front + Vector3d(0, 0, 0.28 + 0.005 * k)));
  }
  const auto standing = FindStandingFigure(Depths(), World().scene.views, World().middle, opinions);
  ASSERT_TRUE(standing);
  double highest = 0;
  for (const Vector3d& x : standing->points) highest = std::max(highest, x.z());
  EXPECT_GT(highest, 0.1);
  EXPECT_LT(highest, 0.29);
}

TEST_F(StandingFigureTest, AClickChoosesTheBoxBesideIt) {
  Opinions opinions;
  opinions.strokes.resize(World().images.size());
  for (std::size_t v = 0; v < World().images.size(); ++v)
    for (int p = 0; p < static_cast<int>(World().things[v].data.size()); p += 61)
      if (World().things[v].data[static_cast<std::size_t>(p)] == kBox)
        opinions.strokes[v].figure.push_back(
            {p % World().images[v].width, p / World().images[v].width});
  const auto standing = FindStandingFigure(Depths(), World().scene.views, World().middle, opinions);
  ASSERT_TRUE(standing);
  for (const Vector3d& x : standing->points) EXPECT_GT(x.x(), 0.27);
}

TEST_F(StandingFigureTest, AWallIsSeenFromTheFrontTheLeftAndTheRight) {
  const auto standing = Standing();
  ASSERT_TRUE(standing);
  EXPECT_FALSE(standing->on_wall);
  // The plane as a wall, before which a person walks to and fro: up in the pictures is y.
  std::vector<View> views = World().scene.views;
  for (std::size_t v = 0; v < views.size(); ++v) {
    const double turn =
        (static_cast<double>(v) / static_cast<double>(views.size() - 1) - 0.5) * 1.8;
    const Vector3d back(std::sin(turn), 0.2, std::cos(turn));
    const Vector3d forward = -back.normalized(),
                   right = forward.cross(Vector3d::UnitY()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    views[v].camera_from_world.rotation = Eigen::Quaterniond(rotation);
    views[v].camera_from_world.translation =
        -(views[v].camera_from_world.rotation * (World().middle - 1.2 * forward));
  }
  const auto relief = FindStandingFigure(Depths(), views, World().middle, {});
  ASSERT_TRUE(relief);
  EXPECT_TRUE(relief->on_wall);
}

}  // namespace keypose::capture::standing_figure_test
