// The shadow against what is known of spheres and boxes on a plane.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "views/film/ground_shadow.h"

namespace keypose::ground_shadow_test {

const Eigen::Vector3d kUp = Eigen::Vector3d::UnitZ();

/// A unit sphere whose centre is `height` above the plane z = 0.
Mesh SphereAt(double height) {
  Mesh sphere = MakeIcosphere(5);
  sphere.points.col(2).array() += height;
  return sphere;
}

/// The table at z = 0, as for a sphere that rests on it in another frame.
Ground TableOfRestingSphere() { return GroundUnder({SphereAt(1)}, kUp); }

/// The share that a sphere hides of a point that is `radius` from the point below its centre: the
/// form factor of a sphere above the horizon.
double HiddenBySphere(double height, double radius) {
  return height / std::pow(height * height + radius * radius, 1.5);
}

TEST(GroundShadow, SphereHidesItsFormFactor) {
  for (const double height : {1.0, 1.5, 3.0}) {
    const Mesh sphere = SphereAt(height);
    const GroundShadow shadow(RayScene(sphere.points, sphere.faces), TableOfRestingSphere());
    double worst = 0, sum = 0;
    int count = 0;
    for (double radius = 0; radius < 3; radius += 0.05)
      for (const double angle : {0.3, 2.0, 4.4}) {
        const Eigen::Vector3d point(radius * std::cos(angle), radius * std::sin(angle), 0);
        const double error = shadow.Hidden(point) - HiddenBySphere(height, radius);
        worst = std::max(worst, std::abs(error));
        sum += error * error;
        ++count;
      }
    // 256 directions, and means over neighbouring points
    EXPECT_LT(worst, 0.03) << "height " << height;
    EXPECT_LT(std::sqrt(sum / count), 0.008) << "height " << height;
  }
}

TEST(GroundShadow, DarkestAtTheContactAndNoneFarAway) {
  const Mesh sphere = SphereAt(1);
  const GroundShadow shadow(RayScene(sphere.points, sphere.faces), TableOfRestingSphere());
  EXPECT_GT(shadow.Hidden({0, 0, 0}), 0.99);
  double nearer = 1.01;
  for (double radius = 0; radius < 4.6; radius += 0.25) {
    const double hidden = shadow.Hidden({0, radius, 0});
    EXPECT_LT(hidden, nearer) << radius;
    nearer = hidden;
  }
  EXPECT_EQ(shadow.Hidden({0, 4.7, 0}), 0);
  EXPECT_EQ(shadow.Hidden({-300, 900, 0}), 0);
}

TEST(GroundShadow, SoleThatLiesOnTheTableHidesAllBelowItAndAWallHalf) {
  const Mesh box = MakeBox(4, 4, 40);
  const Ground ground = GroundUnder({box}, kUp);
  const GroundShadow shadow(RayScene(box.points, box.faces), ground);
  for (const double x : {0.5, 2.0, 3.0})
    EXPECT_NEAR(shadow.Hidden({x, 2, 0}), 1, 1e-6) << "below the sole";
  // A point at the foot of a wall sees one half of the sky. This wall is 4 wide and 40 high: at a
  // distance of a tenth it leaves a little more. The share is that of a strip without end upwards.
  const double distance = 0.5, half_width = 2;
  const double strip = half_width / std::hypot(half_width, distance) / 2;
  EXPECT_NEAR(shadow.Hidden({4 + distance, 2, 0}), strip, 0.05);
}

TEST(GroundShadow, TurnsWithTheAxis) {
  Mesh figure = MakeBox(1, 0.5, 2), turned = figure;
  turned.points.col(1) = figure.points.col(2);  // (x, y, z) -> (x, z, -y)
  turned.points.col(2) = -figure.points.col(1);
  const GroundShadow z_up(RayScene(figure.points, figure.faces), GroundUnder({figure}, kUp));
  const GroundShadow y_up(RayScene(turned.points, turned.faces),
                          GroundUnder({turned}, Eigen::Vector3d::UnitY()));
  double most = 0;
  for (double x = -1; x < 2; x += 0.17) {
    const double hidden = z_up.Hidden({x, 0.7, 0});
    most = std::max(most, hidden);
    EXPECT_NEAR(y_up.Hidden({x, 0, -0.7}), hidden, 0.02) << x;
  }
  EXPECT_GT(most, 0.3);
}

TEST(GroundShadow, SameBitsForAnyThreadCount) {
  const Mesh sphere = SphereAt(1);
  const RayScene rays(sphere.points, sphere.faces);
  const auto values = [&](int threads) {
    SetThreadCount(threads);
    const GroundShadow shadow(rays, TableOfRestingSphere());
    SetThreadCount(0);
    std::vector<double> hidden;
    for (double x = -4; x < 4; x += 0.01) hidden.push_back(shadow.Hidden({x, 0.3, 0}));
    return hidden;
  };
  EXPECT_EQ(values(1), values(3));
}

TEST(GroundUnder, TouchesTheLowestPointOfAllFrames) {
  std::vector<Mesh> frames(3, MakeBox(1, 1, 1));
  frames[1].points.col(2).array() -= 0.25;
  frames[2].points.col(0).array() += 2;
  const Ground ground = GroundUnder(frames, kUp);
  EXPECT_TRUE(ground.origin.isApprox(Eigen::Vector3d(1.5, 0.5, -0.25)));
  EXPECT_DOUBLE_EQ(ground.reach, 1.5);
  EXPECT_NEAR(ground.right.cross(ground.back).dot(ground.up), 1, 1e-12);
}

}  // namespace keypose::ground_shadow_test
