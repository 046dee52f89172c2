#include "synth/worlds/pose.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/values/errors.h"
#include "synth/worlds/world.h"

namespace keypose::synth::pose_test {

using Eigen::Vector3d;

constexpr double kPi = 3.141592653589793;

Deformation QuarterBend() {
  Deformation bend;
  bend.kind = Deformation::Kind::kBend;
  bend.axis = Vector3d::UnitZ();
  bend.hinge = Vector3d::UnitX();
  bend.begin = 0.1;
  bend.end = 0.3;
  bend.angle = kPi / 2;
  return bend;
}

WorldOptions Coarse(std::uint64_t seed = 1) {
  WorldOptions options;
  options.seed = seed;
  options.spacing_m = 0.006;
  return options;
}

TEST(Deformation, BendWrapsTheAxisRoundAQuarterCircle) {
  const Deformation bend = QuarterBend();
  const double radius = 0.2 / (kPi / 2);
  const auto at = [&](double s) { return bend.Apply({0, 0, s}, {0, 0, s}); };
  EXPECT_LT((at(0.05) - Vector3d(0, 0, 0.05)).norm(), 1e-15);
  // The limb bends towards hinge x axis: -y.
  EXPECT_LT((at(0.3) - Vector3d(0, -radius, 0.1 + radius)).norm(), 1e-15);
  EXPECT_LT((at(0.5) - Vector3d(0, -radius - 0.2, 0.1 + radius)).norm(), 1e-15);
  EXPECT_NEAR((at(0.2 + 1e-6) - at(0.2 - 1e-6)).norm(), 2e-6,
              1e-15);  // arc length is kept on the axis
}

TEST(Deformation, BendChangesVolumeByOneMinusCurvatureTimesOffset) {
  Pose pose{"bent", {QuarterBend()}};
  const double curvature = (kPi / 2) / 0.2;
  for (const double y : {-0.03, 0.0, 0.05}) {
    const double offset = -y;  // towards the side to which the limb bends
    EXPECT_NEAR(pose.Jacobian({0.02, y, 0.2}).determinant(), 1 - curvature * offset, 1e-7) << y;
  }
}

TEST(Deformation, TwistAndSquashKeepVolume) {
  Deformation twist;
  twist.kind = Deformation::Kind::kTwist;
  twist.angle = 1.2;
  Deformation squash;
  squash.kind = Deformation::Kind::kSquash;
  squash.ratio = 0.7;
  EXPECT_NEAR((Pose{"t", {twist}}).Jacobian({0.03, -0.02, 0.05}).determinant(), 1, 1e-7);
  EXPECT_NEAR((Pose{"s", {squash}}).Jacobian({0.03, -0.02, 0.05}).determinant(), 1, 1e-7);
}

TEST(Deformation, BallConfinesTheBend) {
  Deformation bend = QuarterBend();
  bend.center = Vector3d(0, 0, 0.2);
  bend.radius = 0.05;
  bend.falloff = 0.02;
  const Vector3d outside(0.08, 0, 0.2), inside(0.01, 0, 0.2);
  EXPECT_EQ(bend.Apply(outside, outside), outside);
  EXPECT_GT((bend.Apply(inside, inside) - inside).norm(), 0.001);
}

TEST(Pose, InverseTakesEveryPosedVertexBackToItsMaterialPoint) {
  const World world = MakeWorld(Coarse());
  for (const Pose& pose : world.poses) {
    for (Eigen::Index i = 0; i < world.rest.points.rows(); i += 41) {
      const Vector3d rest = world.rest.points.row(i),
                     guess = rest + Vector3d(0.0005, -0.0004, 0.0003);
      ASSERT_LT((pose.Inverse(pose(rest), guess) - rest).norm(), 1e-8)
          << pose.name << " vertex " << i;
    }
  }
}

TEST(Pose, IsOneToOneOnTheCharactersSurface) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const World world = MakeWorld(Coarse(seed));
    for (const Pose& pose : world.poses)
      for (Eigen::Index i = 0; i < world.rest.points.rows(); i += 7)
        ASSERT_GT(pose.Jacobian(world.rest.points.row(i)).determinant(), 0.15)
            << "seed " << seed << " " << pose.name << " vertex " << i;
  }
}

TEST(Pose, InverseOfAFarGuessThrowsSolverErrorOrFindsThePoint) {
  const Pose flat{"nan", {QuarterBend()}};
  EXPECT_THROW(flat.Inverse(Vector3d::Constant(std::nan("")), Vector3d::Zero()), SolverError);
}

}  // namespace keypose::synth::pose_test
