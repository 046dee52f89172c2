// Parts that moved as rigid bodies, on bodies whose limb turns by a known angle.
#include "register/auto/rigid_parts.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "register/auto/auto_registration.h"
#include "register/testing/scenes.h"

namespace keypose::registration::rigid_parts_test {

using Eigen::Vector3d;

constexpr double kTurned = 0.5;  // of the limb [rad]
const Vector3d kLimb = Vector3d(0.2, 0.9, 0.3).normalized();
const Vector3d kAxis = kLimb.cross(Vector3d(1, 0.2, -0.4)).normalized();

/// Smooth bumps on a ball, in no symmetry; the first two are the limb and its thumb.
double Radius(const Vector3d& direction) {
  const struct {
    Vector3d toward;
    double height, sharpness;
  } bumps[] = {{kLimb, 0.8, 10},           {kLimb + Vector3d(0.5, 0, 0.2), 0.35, 25},
               {{0.9, -0.6, 0.2}, 0.7, 7}, {{-0.7, -0.2, -0.7}, 0.5, 9},
               {{-0.5, 0.1, 0.9}, 0.4, 6}, {{0.4, -0.8, -0.8}, 0.6, 11}};
  double radius = 0.6;
  for (const auto& bump : bumps)
    radius +=
        bump.height * std::exp(bump.sharpness * (direction.dot(bump.toward.normalized()) - 1));
  return radius;
}

/// @param tessellation  turns the corners on the surface, not the surface
Mesh AtRest(const Eigen::Matrix3d& tessellation) {
  Mesh mesh = MakeIcosphere(4);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const Vector3d direction = (tessellation * mesh.points.row(v).transpose()).normalized();
    mesh.points.row(v) = Radius(direction) * direction.transpose();
  }
  return mesh;
}

/// The limb turns about the centre; what is far from it stays.
PointsX3 WithLimbTurned(const PointsX3& points) {
  PointsX3 turned = points;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Vector3d x = points.row(v);
    const double share = 1 / (1 + std::exp(-25 * (x.normalized().dot(kLimb) - 0.6)));
    turned.row(v) = Eigen::AngleAxisd(kTurned * share, kAxis) * x;
  }
  return turned;
}

Similarity3 Micrometres() {
  Similarity3 place;
  place.scale = 150000;
  place.rotation = Eigen::AngleAxisd(-M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  place.translation << 2000, -7000, 40000;
  return place;
}

struct Pair {
  Mesh source = AtRest(Eigen::AngleAxisd(0.7, Vector3d(1, 2, 3).normalized()).toRotationMatrix());
  Mesh target = AtRest(Eigen::AngleAxisd(1.9, Vector3d(-2, 1, 1).normalized()).toRotationMatrix());
  PointsX3 truth;  ///< of the source's vertices
  double diagonal;
  Pair() {
    target.points = Transformed(Micrometres(), WithLimbTurned(target.points));
    truth = Transformed(Micrometres(), WithLimbTurned(source.points));
    diagonal = BoundingDiagonal(target.points);
  }
};

double AngleBetween(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return Eigen::AngleAxisd(a * b.transpose()).angle();
}

TEST(RigidParts, BodyStaysAndTheLimbTurnsByItsAngle) {
  const Pair pair;
  // The guess is 14 degrees off, as a result that has slid.
  Similarity3 guess = Micrometres();
  guess.rotation = guess.rotation * Eigen::AngleAxisd(0.24, Vector3d(1, -1, 0.5).normalized());
  const std::vector<RigidPart> parts =
      FindRigidParts(pair.source, pair.target, Transformed(guess, pair.source.points));
  ASSERT_EQ(parts.size(), 2u);
  EXPECT_LT(AngleBetween(parts[0].target_from_source.rotation, Micrometres().rotation), 0.01);
  EXPECT_NEAR(parts[0].target_from_source.scale / 150000, 1, 0.005);
  EXPECT_GT(parts[0].share, 0.5);
  EXPECT_NEAR(AngleBetween(parts[1].target_from_source.rotation, Micrometres().rotation), kTurned,
              0.05);
  EXPECT_GT(ShareInPlace(parts[0], pair.source, pair.truth, pair.diagonal), 0.98);
  EXPECT_LT(
      ShareInPlace(parts[0], pair.source, Transformed(guess, pair.source.points), pair.diagonal),
      0.1);
}

TEST(RigidParts, NoneOnASurfaceThatSlidesOverItself) {
  const Mesh ball = MakeIcosphere(3);
  EXPECT_TRUE(FindRigidParts(ball, ball, ball.points).empty());
}

TEST(RigidParts, NoneWhereEverythingBends) {
  Pair pair;
  const PointsX3 rest = pair.target.points.array() / 150000;
  pair.target.points = Bent(rest, BoundingDiagonal(rest), 1.2);
  EXPECT_TRUE(FindRigidParts(pair.source, pair.target, pair.source.points).empty());
}

TEST(RigidParts, SmoothBodyDoesNotSlideWhenItsLimbTurns) {
  const Pair pair;
  const AutoResult result = RegisterAuto(pair.source, pair.target, {}, {}, {});
  const Eigen::VectorXd off = (result.points - pair.truth).rowwise().norm() / pair.diagonal;
  EXPECT_LT(off.mean(), 0.01);
  EXPECT_EQ(result.starts[result.chosen].name, "unmoved part");
  EXPECT_EQ(result.rigid_parts, 2);
}

}  // namespace keypose::registration::rigid_parts_test
