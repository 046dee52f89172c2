// A ring model from outlines alone, for a body with exact outlines.
#include <gtest/gtest.h>

#include <cmath>
#include <iterator>

#include "core/numbers/parallel.h"
#include "core/values/errors.h"
#include "reconstruct/turntable/ring_silhouettes.h"
#include "reconstruct/turntable/testing/ring_world.h"

namespace keypose::reconstruct::ring_silhouettes_test {

using Eigen::Vector3d;

constexpr double kPi = 3.14159265358979323846, kDegree = kPi / 180;

struct Ball {
  Vector3d center;
  double radius;
};

/// A figure of balls, of which only the trunk is on the axis: arms, a nose, feet.
const std::vector<Ball> kFigure = {{{0.02, 0.03, 0}, 0.3},     {{0, 0.05, 0.38}, 0.2},
                                   {{0.34, 0.1, 0.12}, 0.12},  {{-0.42, -0.05, 0.2}, 0.1},
                                   {{0.05, -0.22, 0.4}, 0.08}, {{0.15, -0.1, -0.38}, 0.13},
                                   {{-0.16, 0.08, -0.4}, 0.14}};

/// Exact outlines: a pixel is inside when its ray passes within the radius of a ball's centre.
Image8 MaskOf(const Camera& camera, const Rigid3& camera_from_table) {
  Image8 mask(camera.width, camera.height, 1, 0);
  for (const Ball& ball : kFigure) {
    const Vector3d center = camera_from_table * ball.center;
    for (int y = 0; y < camera.height; ++y)
      for (int x = 0; x < camera.width; ++x) {
        const Vector3d ray((x + 0.5 - camera.cx) / camera.fx, (y + 0.5 - camera.cy) / camera.fy, 1);
        if ((center - center.dot(ray) / ray.squaredNorm() * ray).norm() <= ball.radius)
          *mask.at(x, y) = 255;
      }
  }
  return mask;
}

struct World {
  RingModel truth;
  std::vector<Image8> masks;
};

World MakeWorld(const std::vector<double>& elevations_deg, int count, double slop_deg) {
  World world;
  Camera& camera = world.truth.camera;
  camera.width = 480, camera.height = 360, camera.fx = camera.fy = 800, camera.cx = 240,
  camera.cy = 180;
  for (std::size_t r = 0; r < elevations_deg.size(); ++r) {
    const double e = elevations_deg[r] * kDegree;
    const Vector3d aim(0.02, 0.04, 0.05),
        eye = aim + (3 + 0.2 * static_cast<double>(r)) * Vector3d(std::cos(e), 0, std::sin(e));
    const Vector3d forward = (aim - eye).normalized(),
                   right = forward.cross(Vector3d::UnitZ()).normalized();
    Eigen::Matrix3d rotation;
    rotation << right.transpose(), forward.cross(right).transpose(), forward.transpose();
    world.truth.rings.push_back({Eigen::Quaterniond(rotation), -(rotation * eye)});
    world.truth.step_rad.push_back(2 * kPi / count);
    for (int k = 0; k < count; ++k)
      world.truth.views.push_back({static_cast<int>(r) * count + k, static_cast<int>(r),
                                   static_cast<double>(k),
                                   (k + 0.4 * static_cast<double>(r)) * world.truth.step_rad[r] +
                                       slop_deg * kDegree * std::sin(5.0 * k)});
  }
  for (const RingView& view : world.truth.views)
    world.masks.push_back(MaskOf(camera, world.truth.CameraFromTable(view)));
  return world;
}

double CenterError(const RingModel& found, const RingModel& truth) {
  const PointsX3 a = Centers(found), b = Centers(truth);
  return (Transformed(FitSimilarity(a, b), a) - b).rowwise().norm().mean() / 3;
}

// Outlines of 480 x 360 pixels, at the search's width of 240: stereo can start from cameras
// accurate to a hundredth of the distance.
TEST(FitRingToSilhouettes, FindsOneRingFromNothing) {
  const World world = MakeWorld({25}, 16, 0);
  const RingSilhouettes fit = FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(16, {16}),
                                                   world.masks, {.width = 240});
  EXPECT_TRUE(fit.found);
  EXPECT_LT(fit.error_px, 1.0);
  EXPECT_LT(CenterError(fit.model, world.truth), 0.01);
}

TEST(FitRingToSilhouettes, TiesTwoRings) {
  const World world = MakeWorld({10, 40}, 10, 0.4);
  const RingSilhouettes fit = FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(20, {10, 10}),
                                                   world.masks, {.width = 240});
  EXPECT_TRUE(fit.found);
  EXPECT_LT(CenterError(fit.model, world.truth), 0.015);
}

TEST(FitRingToSilhouettes, OutlinesOfAnotherOrderAreNoRing) {
  World world = MakeWorld({25}, 12, 0);
  for (std::size_t k = 0; k < 6; ++k) std::swap(world.masks[k], world.masks[(5 * k + 3) % 12]);
  const double wrong =
      FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(12, {12}), world.masks, {.width = 240})
          .error_px;
  EXPECT_GT(wrong, 2.0);
}

TEST(FitRingToSilhouettes, SameBitsForAnyThreadCountAndErrorsForOtherSizes) {
  World world = MakeWorld({25}, 8, 0);
  RingSilhouetteOptions quick{.width = 120, .rays = 8};
  SetThreadCount(1);
  const RingSilhouettes one =
      FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(8, {8}), world.masks, quick);
  SetThreadCount(3);
  const RingSilhouettes three =
      FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(8, {8}), world.masks, quick);
  SetThreadCount(0);
  EXPECT_EQ(Centers(one.model), Centers(three.model));
  world.masks[3] = Image8(10, 10, 1);
  EXPECT_THROW(FitRingToSilhouettes(world.truth.camera, LayoutOfSizes(8, {8}), world.masks, quick),
               InputError);
}

}  // namespace keypose::reconstruct::ring_silhouettes_test
