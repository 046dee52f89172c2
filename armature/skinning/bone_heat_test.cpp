#include "armature/skinning/bone_heat.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armature/skinning/testing/two_bones.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::armature::bone_heat_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(HeatWeights, SumToOneAndStayWithinZeroAndOne) {
  const TwoBones tube;
  const BoneHeat heat = HeatWeights(tube.mesh, tube.bones);
  ASSERT_EQ(heat.weights.vertex_count(), tube.mesh.vertex_count());
  for (const auto& weights : heat.weights.weights) {
    double sum = 0;
    for (const double weight : weights) {
      EXPECT_GE(weight, 0);
      sum += weight;
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
  EXPECT_EQ(heat.blind_parts, 0);
  // All but those of the caps, in which the bones end.
  EXPECT_GE(heat.seeing, tube.mesh.vertex_count() - 2 * 49);
}

TEST(HeatWeights, FarFromTheJointOneBoneHasAllAndAtTheJointBothHaveHalf) {
  const TwoBones tube;
  const BoneHeat heat = HeatWeights(tube.mesh, tube.bones);
  for (int v = 0; v < tube.mesh.vertex_count(); ++v) {
    const double z = tube.mesh.points(v, 2);
    if (z < 1) {
      EXPECT_EQ(heat.weights.bones[v][0], 0) << z;
      EXPECT_GT(heat.weights.weights[v][0], 0.97) << z;
    }
    if (z > 3) {
      EXPECT_EQ(heat.weights.bones[v][0], 1) << z;
    }
    // At the joint itself both are as near, and the first of them counts.
    if (std::abs(z - 2) < 1e-9) {
      EXPECT_NEAR(heat.weights.weights[v][0], 0.5, 0.1);
    }
  }
}

TEST(HeatWeights, BoneBehindAnotherWallGivesNoHeat) {
  // Two tubes side by side; the second one's vertices are nearer to the first one's bone on one
  // side, but do not see it.
  Mesh one = MakeCylinder(0.25, 2, 32, 20), both = one;
  both.points.resize(2 * one.points.rows(), 3);
  both.faces.resize(2 * one.faces.rows(), 3);
  PointsX3 moved = one.points;
  moved.col(0).array() += 0.6;
  both.points << one.points, moved;
  both.faces << one.faces, (one.faces.array() + one.vertex_count()).matrix();
  // The second tube's own bone lies to the far side.
  const BoneHeat heat =
      HeatWeights(both, {{"a", {0, 0, 0}, {0, 0, 2}}, {"b", {0.78, 0, 0}, {0.78, 0, 2}}});
  for (int v = one.vertex_count(); v < both.vertex_count(); ++v)
    EXPECT_EQ(heat.weights.bones[v][0], 1) << v;
}

TEST(HeatWeights, PartThatSeesNoBoneFollowsItsNearest) {
  Mesh mesh = MakeIcosphere(2);
  const BoneHeat heat =
      HeatWeights(mesh, {{"a", {3, 0, 0}, {4, 0, 0}}, {"b", {-5, 0, 0}, {-6, 0, 0}}});
  EXPECT_EQ(heat.seeing, 0);
  EXPECT_EQ(heat.blind_parts, 1);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    if (mesh.points(v, 0) > 0) {
      EXPECT_EQ(heat.weights.bones[v][0], 0);
    }
}

TEST(HeatWeights, SameBitsForAnyThreadCount) {
  const TwoBones tube;
  SetThreadCount(1);
  const auto one = HeatWeights(tube.mesh, tube.bones).weights.weights;
  SetThreadCount(3);
  const auto three = HeatWeights(tube.mesh, tube.bones).weights.weights;
  SetThreadCount(0);
  EXPECT_EQ(one, three);
}

TEST(HeatWeights, BadInputThrowsInputError) {
  const TwoBones tube;
  EXPECT_THROW(HeatWeights({}, tube.bones), InputError);
  EXPECT_THROW(HeatWeights(tube.mesh, {}), InputError);
  Mesh broken = tube.mesh;
  broken.points(3, 1) = std::nan("");
  EXPECT_THROW(HeatWeights(broken, tube.bones), InputError);
}

}  // namespace keypose::armature::bone_heat_test
