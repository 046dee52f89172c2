#include "armature/skinning/skin.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "armature/skinning/bone_heat.h"
#include "armature/skinning/testing/two_bones.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::armature::skin_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

PointsX3 LinearBlend(const PointsX3& rest, const SkinWeights& skin,
                     const std::vector<Rigid3>& bones) {
  PointsX3 points = PointsX3::Zero(rest.rows(), 3);
  for (Eigen::Index v = 0; v < rest.rows(); ++v)
    for (int k = 0; k < SkinWeights::kMost; ++k)
      points.row(v) +=
          skin.weights[v][k] * (bones[skin.bones[v][k]] * rest.row(v).transpose()).transpose();
  return points;
}

TEST(Skin, OneRigidMotionMovesTheWholeMeshRigidly) {
  const TwoBones tube;
  const Skin skin(tube.mesh.points, HeatWeights(tube.mesh, tube.bones).weights, 2);
  const Rigid3 motion{Quaterniond(Eigen::AngleAxisd(2.8, Vector3d(1, 2, 3).normalized())),
                      Vector3d(4, -5, 6)};
  Rigid3 negative = motion;  // the same motion, written with the other quaternion
  negative.rotation.coeffs() *= -1;
  PointsX3 points;
  skin.Pose({motion, negative}, &points);
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    EXPECT_LT((points.row(v).transpose() - motion * tube.mesh.points.row(v).transpose()).norm(),
              1e-13);
}

TEST(Skin, ElbowBentByARightAngleKeepsItsVolume) {
  const TwoBones tube;
  const SkinWeights weights = HeatWeights(tube.mesh, tube.bones).weights;
  const Skin skin(tube.mesh.points, weights, 2);
  PointsX3 points;
  skin.Pose(TwoBones::Bent(90), &points);
  const double rest = SignedVolume(tube.mesh.points, tube.mesh.faces);
  const double lost = 1 - SignedVolume(points, tube.mesh.faces) / rest;
  const double linear = 1 - SignedVolume(LinearBlend(tube.mesh.points, weights, TwoBones::Bent(90)),
                                         tube.mesh.faces) /
                                rest;
  RecordProperty("volume_lost", std::to_string(lost));
  RecordProperty("volume_lost_by_linear_blend", std::to_string(linear));
  EXPECT_LT(std::abs(lost), 0.03);
  EXPECT_GT(linear, std::abs(lost));
}

TEST(Skin, MirroredBendGivesMirroredMesh) {
  const TwoBones tube;
  const Skin skin(tube.mesh.points, HeatWeights(tube.mesh, tube.bones).weights, 2);
  PointsX3 one, other;
  skin.Pose(TwoBones::Bent(70), &one);
  skin.Pose(TwoBones::Bent(-70), &other);
  // The tube's vertices come in pairs that the mirror y = 0 exchanges.
  for (int ring = 0; ring <= 80; ++ring)
    for (int s = 0; s < 48; ++s) {
      Vector3d mirrored = one.row(48 * ring + s);
      mirrored.y() *= -1;
      EXPECT_LT((other.row(48 * ring + (48 - s) % 48).transpose() - mirrored).norm(), 1e-3);
    }
}

TEST(Skin, WeightsOfAnotherMeshThrowInputError) {
  const TwoBones tube;
  SkinWeights weights = NearestBoneWeights(tube.mesh.points, tube.bones);
  EXPECT_THROW(Skin(tube.mesh.points.topRows(5), weights, 2), InputError);
  EXPECT_THROW(Skin(tube.mesh.points, weights, 1), InputError);
}

TEST(Pruned, FourHeaviestAreKeptAndSumToOne) {
  Eigen::MatrixXd dense(2, 6);
  dense << 0.1, 0.3, 0, 0.05, 0.2, 0.35, 0, 0, 0, 0, -1, 0;
  const SkinWeights skin = Pruned(dense);
  EXPECT_EQ(skin.bones[0], (std::array<std::uint16_t, 4>{5, 1, 4, 0}));
  EXPECT_NEAR(skin.weights[0][0], 0.35 / 0.95, 1e-15);
  EXPECT_EQ(skin.weights[1], (std::array<double, 4>{1, 0, 0, 0}));
}

}  // namespace keypose::armature::skin_test
