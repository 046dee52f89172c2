#include <gtest/gtest.h>

#include "core/numbers/rotations.h"
#include "core/surfaces/shapes.h"
#include "motion/bvh_rig/rigged_mesh.h"
#include "motion/bvh_rig/testing/rigged_body.h"

namespace keypose::motion::rig_test {

TEST(Skinned, BoneTurnsItsVerticesAboutItsHead) {
  const RiggedMesh rig = MakeBody();
  std::vector<BoneMove> moves;
  const Eigen::Matrix3d turn = ExpOf({0.3, 1, -0.2});
  for (const Bone& bone : rig.bones) moves.push_back({turn, turn * bone.head});
  const PointsX3 points = Skinned(rig, moves);
  EXPECT_LT((points - rig.mesh.points * turn.transpose()).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(LargestPart, KeepsItsVerticesInOrder) {
  RiggedMesh rig;
  rig.mesh = MakeBox(1, 1, 1);
  rig.mesh.points.conservativeResize(11, 3);
  rig.mesh.points.bottomRows(3).setRandom();
  rig.mesh.faces.conservativeResize(13, 3);
  rig.mesh.faces.row(12) << 8, 9, 10;
  rig.weights.resize(11);
  const RiggedMesh part = LargestPart(rig);
  EXPECT_EQ(part.mesh.points, MakeBox(1, 1, 1).points);
  EXPECT_EQ(part.mesh.faces, MakeBox(1, 1, 1).faces);
}

}  // namespace keypose::motion::rig_test
