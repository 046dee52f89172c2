#include "composite/light/stated_light.h"

#include <gtest/gtest.h>

#include <cmath>

#include "composite/light/shot_light.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::stated_light_test {

/// A camera that looks along +y, level, from the table's height; up is z.
View LookingAlongY() {
  View view;
  Eigen::Matrix3d camera_from_world;
  camera_from_world << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  view.camera_from_world.rotation = Eigen::Quaterniond(camera_from_world);
  return view;
}

TEST(StatedLight, LampsStandWhereThePictureHasThem) {
  const View view = LookingAlongY();
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  StatedLight light;
  light.height_deg = 30;
  const double low = std::sqrt(0.75);
  const auto lamp = [&](double from) {
    light.from_deg = from;
    return LampOf(light, view, up);
  };
  EXPECT_TRUE(lamp(0).isApprox(Eigen::Vector3d(0, -low, 0.5), 1e-12)) << "the camera's side";
  EXPECT_TRUE(lamp(90).isApprox(Eigen::Vector3d(low, 0, 0.5), 1e-12)) << "the right";
  EXPECT_TRUE(lamp(-90).isApprox(Eigen::Vector3d(-low, 0, 0.5), 1e-12)) << "the left";
  EXPECT_TRUE(lamp(180).isApprox(Eigen::Vector3d(0, low, 0.5), 1e-12)) << "behind";
  View down = view;  // from above, the picture's upper side to +y
  down.camera_from_world.rotation = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  EXPECT_TRUE(LampOf(light, down, up).isApprox(Eigen::Vector3d(0, low, 0.5), 1e-12));
}

TEST(StatedLight, AnEvenSkyLeavesTheTexturesAndALampShades) {
  const View view = LookingAlongY();
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  StatedLight light;
  light.brightness = 1.25;
  const Mesh sphere = MakeIcosphere(3);
  const PointsX3 even = GainsBetween(LightOf(light, false, view, up), -1, -1, 0, sphere.points);
  EXPECT_LT((even.array() - 1.25).abs().maxCoeff(), 1e-12);
  const PointsX3 plain = GainsBetween(LightOf(light, true, view, up), -1, -1, 0, sphere.points);
  for (Eigen::Index v = 0; v < plain.rows(); ++v) {
    const double above = (1 + sphere.points.row(v).normalized().z()) / 2, level = 0.6;
    EXPECT_NEAR(plain(v, 0), 1.25 * (above + 0.2 * (1 - above)) / level, 1e-9);
  }
  light.brightness = 1, light.lamp = 0.6, light.from_deg = 35;
  const Eigen::Vector3d lamp = LampOf(light, view, up);
  const PointsX3 gains = GainsBetween(LightOf(light, false, view, up), -1, -1, 0, sphere.points);
  for (Eigen::Index v = 0; v < gains.rows(); ++v) {
    const double lambert = std::max(0.0, sphere.points.row(v).normalized().dot(lamp));
    // Degree 2 differs from the clamped cosine by 1/4 - 5/32 at most, at its edge.
    EXPECT_NEAR(gains(v, 1), 0.4 + 0.6 * 2 * lambert, 0.6 * 2 * 3 / 32 + 1e-9);
  }
}

TEST(StatedLight, TheShadowTakesOfTheTableWhatLampAndSkyGiveIt) {
  const View view = LookingAlongY();
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  StatedLight light;
  ShadowStrength strength = ShadowOf(light, view, up);
  EXPECT_NEAR(strength.sky, 0.8, 1e-12) << "the set gives a fifth back";
  EXPECT_EQ(strength.lamp, 0);
  light.lamp = 0.5, light.height_deg = 90;
  strength = ShadowOf(light, view, up);
  EXPECT_NEAR(strength.lamp, 2.0 / 3, 1e-12) << "a lamp overhead gives twice the sky's light";
  EXPECT_NEAR(strength.sky, 0.8 / 3, 1e-12);
  EXPECT_NEAR(strength.light.radius_rad, 7.5 * M_PI / 180, 1e-12);
}

}  // namespace keypose::composite::stated_light_test
