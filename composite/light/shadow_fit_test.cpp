#include "composite/light/shadow_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/shapes.h"

namespace keypose::composite::shadow_fit_test {

TEST(ShadowFit, FindsLampAndStrengths) {
  Mesh ball = MakeIcosphere(3);
  ball.points.col(2).array() += 1;
  const RayScene scene(ball.points, ball.faces);
  const Ground table = GroundUnder({ball}, Eigen::Vector3d::UnitZ());
  const ShadowStrength truth{0.35, 0.5, {Eigen::Vector3d(-0.5, 0.4, 0.7).normalized(), 0.08}};
  const TableShadow shadow(scene, table, truth);
  ShadowSamples samples{&scene, {}, {}};
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j) {
      const Eigen::Vector3d place(0.15 * i, 0.15 * j, 0);
      samples.places.push_back(place);
      samples.lost.push_back(1 - shadow.Kept(place));
    }
  samples.lost[10] = 0.9;  // something else that moved
  const ShadowFit fit = FitShadow({samples}, table);
  const double cosine = fit.strength.light.direction.dot(truth.light.direction);
  EXPECT_LT(std::acos(std::min(1.0, cosine)) * 180 / M_PI, 5);
  EXPECT_NEAR(fit.strength.sky, truth.sky, 0.08);
  EXPECT_NEAR(fit.strength.lamp, truth.lamp, 0.08);
  EXPECT_GT(fit.explained, 0.8);
}

TEST(ShadowFit, TwoFramesShowItWithoutAPlate) {
  Mesh ball = MakeIcosphere(3), there = ball;
  ball.points.col(2).array() += 1;
  there.points = ball.points.rowwise() + Eigen::RowVector3d(1.2, 0.4, 0);
  const RayScene here(ball.points, ball.faces), away(there.points, there.faces);
  const Ground table = GroundUnder({ball, there}, Eigen::Vector3d::UnitZ());
  const ShadowStrength truth{0.35, 0.5, {Eigen::Vector3d(-0.5, 0.4, 0.7).normalized(), 0.08}};
  const TableShadow first(here, table, truth), second(away, table, truth);
  ShadowSamples samples{&here, {}, {}, &away};
  for (int i = -20; i <= 20; ++i)
    for (int j = -20; j <= 20; ++j) {
      const Eigen::Vector3d place(0.6 + 0.15 * i, 0.2 + 0.15 * j, 0);
      if (second.Kept(place) < 0.1) continue;
      samples.places.push_back(place);
      samples.lost.push_back(1 - first.Kept(place) / second.Kept(place));
    }
  const ShadowFit fit = FitShadow({samples}, table);
  EXPECT_LT(std::acos(std::min(1.0, fit.strength.light.direction.dot(truth.light.direction))), 0.1);
  EXPECT_NEAR(fit.strength.sky, truth.sky, 0.08);
  EXPECT_NEAR(fit.strength.lamp, truth.lamp, 0.08);
  EXPECT_GT(fit.explained, 0.8);
}

TEST(ShadowFit, NothingLostIsNoShadow) {
  Mesh ball = MakeIcosphere(2);
  ball.points.col(2).array() += 1;
  const RayScene scene(ball.points, ball.faces);
  const Ground table = GroundUnder({ball}, Eigen::Vector3d::UnitZ());
  ShadowSamples few{&scene, {{1, 0, 0}}, {0.5}};
  EXPECT_EQ(FitShadow({few}, table).strength.lamp, 0);
}

}  // namespace keypose::composite::shadow_fit_test
