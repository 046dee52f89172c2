// Weights of bones, and what they do to a mesh.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "armature/skinning/bone_heat.h"
#include "armature/skinning/skin.h"
#include "armature/skinning/stick_mesh.h"
#include "armature/skinning/weights_text.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature::skinning_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

/// A tube along z with a bone in its lower and one in its upper half.
struct TwoBones {
  Mesh mesh = MakeCylinder(0.25, 4, 48, 80);
  std::vector<SkinBone> bones = {{"lower", {0, 0, 0}, {0, 0, 2}}, {"upper", {0, 0, 2}, {0, 0, 4}}};

  static std::vector<Rigid3> Bent(double degrees) {
    const Quaterniond turn(Eigen::AngleAxisd(degrees * kDegree, Vector3d::UnitX()));
    return {{}, {turn, Vector3d(0, 0, 2) - turn * Vector3d(0, 0, 2)}};
  }
};

PointsX3 LinearBlend(const PointsX3& rest, const SkinWeights& skin,
                     const std::vector<Rigid3>& bones) {
  PointsX3 points = PointsX3::Zero(rest.rows(), 3);
  for (Eigen::Index v = 0; v < rest.rows(); ++v)
    for (int k = 0; k < SkinWeights::kMost; ++k)
      points.row(v) +=
          skin.weights[v][k] * (bones[skin.bones[v][k]] * rest.row(v).transpose()).transpose();
  return points;
}

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

TEST(StickFigure, IsClosedAndMovesWithItsBones) {
  const TwoBones tube;
  const StickFigure figure = MakeStickFigure(tube.bones);
  const ClosedReport closed = CheckClosed(figure.mesh);
  EXPECT_TRUE(closed.closed());
  EXPECT_EQ(closed.components, 4);
  const Skin skin(figure.mesh.points, figure.weights, 2);
  PointsX3 points;
  skin.Pose(TwoBones::Bent(90), &points);
  EXPECT_NEAR(points.col(1).minCoeff(), -2, 0.25);  // the upper bone's ball
  EXPECT_THROW(MakeStickFigure({}), InputError);
}

std::string FaultOf(const std::string& text) {
  try {
    ParseWeights(text, "w", {"a", "b"}, {0, 1}, 2);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ParseWeights, ReadsJsonAndDmat) {
  const SkinWeights json = ParseWeights(R"({"weights": {"a": [[0, 2], [1, 1]], "b": [[1, 3]]}})",
                                        "w", {"a", "b"}, {0, 1}, 2);
  EXPECT_EQ(json.weights[0][0], 1);
  EXPECT_EQ(json.bones[1][0], 1);
  EXPECT_NEAR(json.weights[1][0], 0.75, 1e-15);
  const SkinWeights dmat = ParseWeights("2 2\n2 1\n0 3\n", "w", {"a", "b"}, {0, 1}, 2);
  EXPECT_EQ(dmat.weights, json.weights);
  EXPECT_EQ(dmat.bones[1], json.bones[1]);
}

TEST(ParseWeights, SaysWhatIsWrong) {
  EXPECT_NE(FaultOf("{").find("armature: w is not JSON"), std::string::npos);
  EXPECT_NE(FaultOf(R"({"weights": {"a": [[0, 1]]}})").find("vertex 1"), std::string::npos);
  EXPECT_NE(FaultOf("2 2 1 0 1 0").find("vertex 1"), std::string::npos);
}

}  // namespace keypose::armature::skinning_test
