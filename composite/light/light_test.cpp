#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "composite/layer/linear_light.h"
#include "composite/light/grain.h"
#include "composite/light/plate_exposure.h"
#include "composite/light/shadow_fit.h"
#include "composite/light/shot_light.h"
#include "composite/light/stated_light.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::composite::light_test {

/// A picture with all levels between 30 and 220.
ImageF Ramp(int width, int height) {
  ImageF ramp(width, height, 3);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        ramp.at(x, y)[c] = 30 + 190.0f * static_cast<float>((x + 13 * c) % width) / width;
  return ramp;
}

TEST(Exposure, WhatMovedDoesNotCount) {
  ImageF plate(90, 60, 3, 0.3f), picture = plate;
  const float factors[3] = {1.2f, 1.0f, 0.8f};
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 90; ++x)
      for (int c = 0; c < 3; ++c)
        picture.at(x, y)[c] = x < 25 ? 0.7f : factors[c] * plate.at(x, y)[c];
  const Eigen::Vector3d found = ExposureOf(picture, plate, {});
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], factors[c], 1e-5);
  const Image8 everywhere(90, 60, 1, 255);
  EXPECT_EQ(ExposureOf(picture, plate, everywhere), Eigen::Vector3d::Ones());
}

Grain GrainOf(double sigma, double neighbours) {
  Grain grain;
  for (auto& channel : grain.sigma) channel.fill(sigma);
  grain.neighbours = neighbours;
  return grain;
}

TEST(Grain, MadeGrainMeasuresTheSame) {
  const ImageF clean = Ramp(320, 200);
  for (const double sigma : {1.0, 3.0, 6.0})
    for (const double neighbours : {0.0, 0.4}) {
      const Grain grain = GrainOf(sigma, neighbours);
      const Image8 a = Rounded(WithGrain(clean, grain, {}, 1)),
                   b = Rounded(WithGrain(clean, grain, {}, 2));
      const auto measured = MeasureGrain(a, b, {});
      ASSERT_TRUE(measured);
      EXPECT_NEAR(measured->MeanSigma(), sigma, 0.1 * sigma + 0.1);
      EXPECT_NEAR(measured->neighbours, neighbours, 0.08) << sigma;
    }
}

TEST(Grain, WhatMovedIsNotGrain) {
  const ImageF clean = Ramp(320, 200);
  const Grain grain = GrainOf(2, 0);
  const Image8 a = Rounded(WithGrain(clean, grain, {}, 1));
  Image8 b = Rounded(WithGrain(clean, grain, {}, 2));
  std::mt19937 random(5);
  for (int y = 40; y < 120; ++y)
    for (int x = 60; x < 160; ++x)
      for (int c = 0; c < 3; ++c) b.at(x, y)[c] = static_cast<std::uint8_t>(random() % 250);
  EXPECT_NEAR(MeasureGrain(a, b, {})->MeanSigma(), 2, 0.7);
}

TEST(Grain, SeedAndShareDecide) {
  const ImageF clean = Ramp(80, 50);
  const Grain grain = GrainOf(4, 0.2);
  EXPECT_EQ(WithGrain(clean, grain, {}, 7).data, WithGrain(clean, grain, {}, 7).data);
  EXPECT_NE(WithGrain(clean, grain, {}, 7).data, WithGrain(clean, grain, {}, 8).data);
  const ImageF none(80, 50, 1, 0.0f);
  EXPECT_EQ(WithGrain(clean, grain, none, 7).data, clean.data) << "fractions of a level stay";
  EXPECT_FALSE(MeasureGrain(Image8(20, 20, 3, 100), Image8(20, 20, 3, 100), {}));
}

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

double LampLight(const Eigen::Vector3d& normal) {
  const Eigen::Vector3d lamp = Eigen::Vector3d(-0.6, -0.6, 0.5).normalized();
  return 0.4 + 0.8 * std::max(0.0, normal.dot(lamp));
}

/// A ball, filmed from the front in a lamp's light; its texture is 0.3.
struct LitBall {
  Mesh mesh = MakeIcosphere(4);
  RayScene scene{mesh.points, mesh.faces};
  View view{"", {160, 120, 150, 150, 80, 60}, LookAt({0, -4, 1}, {0, 0, 0})};
  ImageF filmed{160, 120, 3, 0.1f}, layer{160, 120, 4};

  LitBall() {
    const Rigid3 world_from_camera = view.camera_from_world.Inverse();
    for (int y = 0; y < 120; ++y)
      for (int x = 0; x < 160; ++x) {
        const Eigen::Vector3d ray =
            world_from_camera.rotation * view.camera.Unproject({x + 0.5, y + 0.5});
        const RayScene::Hit hit = scene.Cast(world_from_camera.translation, ray);
        if (hit.face < 0) continue;
        const Eigen::Vector3d normal =
            (world_from_camera.translation + hit.distance * ray).normalized();
        for (int c = 0; c < 3; ++c) {
          layer.at(x, y)[c] = 0.3f;
          filmed.at(x, y)[c] = static_cast<float>(0.3 * LampLight(normal) * (c == 2 ? 0.9 : 1));
        }
        layer.at(x, y)[3] = 1;
      }
  }
};

TEST(Shading, GainsOfAFilmedFrameComeBack) {
  const LitBall ball;
  const ObservedGains observed = ObserveGains(ball.filmed, ball.layer, {}, ball.mesh.points,
                                              ball.mesh.faces, ball.scene, ball.view, 0.8);
  const ShotLight light = FitShotLight({observed}, ball.mesh.faces);
  const PointsX3 normals = VertexNormals(ball.mesh.points, ball.mesh.faces);
  const PointsX3 gains = GainsBetween(light, 0, 0, 0, normals);
  int seen = 0;
  for (Eigen::Index v = 0; v < gains.rows(); ++v) {
    if (observed.weights[v] < 0.4) continue;
    EXPECT_NEAR(gains(v, 0), LampLight(normals.row(v)), 0.06);
    EXPECT_NEAR(gains(v, 2), 0.9 * LampLight(normals.row(v)), 0.06);
    ++seen;
  }
  EXPECT_GT(seen, 400);
  EXPECT_GT(gains.minCoeff(), 0);
}

TEST(Shading, WithoutObservationsTheTextureStaysAsItIs) {
  const ShotLight light = FitShotLight({}, MakeIcosphere(1).faces);
  const PointsX3 normals = PointsX3::Random(5, 3);
  EXPECT_LT((GainsBetween(light, -1, -1, 0, normals) - PointsX3::Ones(5, 3)).norm(), 1e-12);
}

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

}  // namespace keypose::composite::light_test
