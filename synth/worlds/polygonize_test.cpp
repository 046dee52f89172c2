#include "synth/worlds/polygonize.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::synth::polygonize_test {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;
constexpr double kRadius = 0.05;

double Ball(const Vector3d& x) { return (x - Vector3d(0.003, -0.002, 0.001)).norm() - kRadius; }
double Ring(const Vector3d& x) {
  return Vector3d(std::hypot(x[0], x[1]) - 0.05, x[2], 0).norm() - 0.018;
}

Mesh PolygonizedBall(double spacing) {
  return Polygonize(Ball, Vector3d::Constant(-0.07), Vector3d::Constant(0.07), spacing);
}

TEST(Polygonize, BallIsClosedAndHasSphereTopology) {
  const ClosedReport report = CheckClosed(PolygonizedBall(0.006));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.components, 1);
  EXPECT_EQ(report.euler, 2);
}

TEST(Polygonize, TorusIsClosedWithItsHoleAndVolume) {
  const Mesh torus = Polygonize(Ring, Vector3d::Constant(-0.08), Vector3d::Constant(0.08), 0.004);
  const ClosedReport report = CheckClosed(torus);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.euler, 0);
  const double volume = 2 * kPi * kPi * 0.05 * 0.018 * 0.018;
  EXPECT_NEAR(report.volume / volume, 1, 0.02);  // chords of 2 mm on a tube of 18 mm
}

TEST(Polygonize, VolumeAndAreaConvergeQuadraticallyToTheSphere) {
  const double volume = 4 * kPi / 3 * std::pow(kRadius, 3), area = 4 * kPi * kRadius * kRadius;
  double volume_error[2], area_error[2];
  for (int i = 0; i < 2; ++i) {
    const Mesh ball = PolygonizedBall(i == 0 ? 0.008 : 0.004);
    volume_error[i] = std::abs(SignedVolume(ball.points, ball.faces) / volume - 1);
    area_error[i] = std::abs(SurfaceArea(ball.points, ball.faces) / area - 1);
  }
  EXPECT_LT(volume_error[1], 0.004);
  EXPECT_LT(area_error[1], 0.004);
  // A chord's error is proportional to the square of its length: half the spacing gives about a
  // quarter.
  EXPECT_NEAR(volume_error[0] / volume_error[1], 4, 1);
}

TEST(Polygonize, VerticesLieOnTheSurface) {
  const double spacing = 0.006;
  const Mesh ball = PolygonizedBall(spacing);
  for (Eigen::Index i = 0; i < ball.points.rows(); ++i)
    ASSERT_LT(std::abs(Ball(ball.points.row(i))), 0.02 * spacing) << "vertex " << i;
}

TEST(Polygonize, SameBitsAtOneAndManyThreads) {
  SetThreadCount(1);
  const Mesh one = PolygonizedBall(0.006);
  SetThreadCount(4);
  const Mesh many = PolygonizedBall(0.006);
  SetThreadCount(0);
  EXPECT_EQ(one.faces, many.faces);
  EXPECT_EQ(one.points, many.points);
}

TEST(Polygonize, NothingInsideTheBoxThrowsInputError) {
  EXPECT_THROW(
      Polygonize([](const Vector3d&) { return 1.0; }, Vector3d::Zero(), Vector3d::Ones(), 0.1),
      InputError);
  EXPECT_THROW(Polygonize(Ball, Vector3d::Zero(), Vector3d::Ones(), 0), InputError);
  EXPECT_THROW(Polygonize(Ball, Vector3d::Zero(), Vector3d::Ones(), 1e-5), InputError);
}

}  // namespace keypose::synth::polygonize_test
