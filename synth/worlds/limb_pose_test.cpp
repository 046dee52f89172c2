#include "synth/worlds/limb_pose.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/surfaces/self_intersections.h"
#include "core/values/errors.h"
#include "synth/worlds/world.h"

namespace keypose::synth::limb_pose_test {

using Eigen::Vector3d;

World LimbWorld(std::uint64_t pose_seed, std::uint64_t seed = 1, double spacing_m = 0.006) {
  WorldOptions options;
  options.seed = seed;
  options.pose_seed = pose_seed;
  options.spacing_m = spacing_m;
  return MakeWorld(options);
}

double LeastDeterminant(const World& world, const Pose& pose) {
  std::vector<double> values(static_cast<std::size_t>(world.rest.points.rows()));
  ParallelFor(
      world.rest.points.rows(),
      [&](std::int64_t i) { values[i] = pose.Jacobian(world.rest.points.row(i)).determinant(); },
      256);
  return *std::min_element(values.begin(), values.end());
}

// On a surface with four times as many vertices as the one that poses are chosen on.
void ExpectSoundPoses(int seeds) {
  double sum = 0;
  int limbs = 0;
  for (std::uint64_t seed = 1; seed <= static_cast<std::uint64_t>(seeds); ++seed) {
    const World world = LimbWorld(seed, 1, 0.003);
    const Pose& pose = world.PoseNamed("limbs");
    EXPECT_GT(LeastDeterminant(world, pose), 0.1) << "pose seed " << seed;
    EXPECT_FALSE(
        HasSelfIntersections(pose(world.rest.points), world.rest.faces, TouchingFaces::kCounted))
        << "pose seed " << seed;
    for (const PosableLimb& limb : world.limbs) {
      const double angle = LimbAngleDeg(pose, limb);
      EXPECT_GE(angle, 30) << "pose seed " << seed << " " << limb.name;
      EXPECT_LE(angle, 120) << "pose seed " << seed << " " << limb.name;
      sum += angle, ++limbs;
    }
  }
  EXPECT_EQ(limbs, seeds * 4);
  ::testing::Test::RecordProperty("mean_deg", std::to_string(sum / limbs));
  // Angles are drawn evenly from 30 to 120; collisions make some of them smaller.
  EXPECT_GT(sum / limbs, 55);
  EXPECT_LT(sum / limbs, 85);
}

TEST(RandomLimbPose, FiveSeedsAreOneToOneWithoutSelfIntersection) { ExpectSoundPoses(5); }

TEST(RandomLimbPoseFull, ThirtySeedsAreOneToOneWithoutSelfIntersection) { ExpectSoundPoses(30); }

TEST(RandomLimbPose, OtherCharactersCanTakeItToo) {
  for (std::uint64_t seed = 2; seed <= 7; ++seed) {
    const World world = LimbWorld(seed + 40, seed, 0.004);
    const Pose& pose = world.PoseNamed("limbs");
    EXPECT_GT(LeastDeterminant(world, pose), 0.1) << "seed " << seed;
    EXPECT_FALSE(
        HasSelfIntersections(pose(world.rest.points), world.rest.faces, TouchingFaces::kCounted))
        << "seed " << seed;
  }
}

TEST(RandomLimbPose, MovesLimbsAndLeavesTheBody) {
  const World world = LimbWorld(3);
  const Pose& pose = world.PoseNamed("limbs");
  for (const TruthLandmark& landmark : world.landmarks) {
    const Vector3d rest = world.rest.points.row(landmark.vertex);
    const double moved_m = (pose(rest) - rest).norm();
    if (landmark.name == "nose" || landmark.name == "button" || landmark.name == "left_eye") {
      EXPECT_EQ(moved_m, 0) << landmark.name;
    }
    if (landmark.name == "tail_tip" || landmark.name == "left_finger" ||
        landmark.name == "right_fist" || landmark.name == "ear_tip") {
      EXPECT_GT(moved_m, 0.008) << landmark.name;
    }
  }
}

TEST(RandomLimbPose, SamePoseForAnyResolutionAndThreadCount) {
  SetThreadCount(1);
  const World coarse = LimbWorld(5);
  SetThreadCount(4);
  const World fine = LimbWorld(5, 1, 0.004);
  SetThreadCount(0);
  const PointsX3& points = coarse.rest.points;
  EXPECT_EQ(coarse.PoseNamed("limbs")(points), fine.PoseNamed("limbs")(points));
}

TEST(RandomLimbPose, SeedsDiffer) {
  const World one = LimbWorld(1), two = LimbWorld(2);
  const PointsX3& points = one.rest.points;
  const PointsX3 apart = one.PoseNamed("limbs")(points) - two.PoseNamed("limbs")(points);
  EXPECT_GT(apart.rowwise().norm().maxCoeff(), 0.02);
}

TEST(LimbAngleDeg, OfALimbBentByADeformationIsItsAngle) {
  const World world = LimbWorld(1);
  const PosableLimb& arm = world.limbs.front();
  EXPECT_NEAR(LimbAngleDeg(world.PoseNamed("rest"), arm), 0, 1e-6);
  const Pose bent{"bent", {LimbBend({0, 0, 0}, Vector3d::UnitZ(), Vector3d::UnitX(), 0, 0.01, 37)}};
  EXPECT_NEAR(LimbAngleDeg(bent, arm), 37, 1e-4);  // central differences
}

TEST(MakeWorld, LimbPoseExistsOnlyWhenAskedFor) {
  EXPECT_THROW(LimbWorld(0).PoseNamed("limbs"), UsageError);
  WorldOptions columns;
  columns.character = "columns";
  columns.pose_seed = 1;
  EXPECT_THROW(MakeWorld(columns), UsageError);
}

}  // namespace keypose::synth::limb_pose_test
