#include "register/nricp/alignment.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "register/nricp/testing/bumpy_ball.h"

namespace keypose::registration::alignment_test {

TEST(AlignGlobally, FindsATurnWithoutLandmarks) {
  const Mesh source = Bumpy(3);
  Mesh target = Bumpy(3);
  Similarity3 truth;
  truth.rotation =
      Eigen::AngleAxisd(1.8, Eigen::Vector3d(0.1, -0.2, 1).normalized()).toRotationMatrix();
  truth.scale = 1.4;
  truth.translation << 3, 4, 5;
  target.points = Transformed(truth, source.points);
  const Alignment found = AlignGlobally(source, target, {}, {});
  EXPECT_EQ(found.method, "icp");
  const PointsX3 moved = Transformed(found.target_from_source, source.points);
  EXPECT_LT((moved - target.points).rowwise().norm().mean() / BoundingDiagonal(target.points),
            0.02);  // 500 samples: their spacing is 0.04
}

TEST(AlignGlobally, OneLandmarkDecidesBetweenSymmetricPoses) {
  const Mesh box = MakeBox(1, 2, 4);
  PointsX3 a(1, 3), b(1, 3);
  a << 1, 2, 4;
  b << 0, 0, 4;  // half a turn about z
  const Alignment found = AlignGlobally(box, box, a, b);
  EXPECT_EQ(found.method, "icp with landmarks");
  EXPECT_LT((found.target_from_source * Eigen::Vector3d(1, 2, 4) - Eigen::Vector3d(0, 0, 4)).norm(),
            0.1);
}

TEST(AlignGlobally, LandmarksThatMirrorStillGiveARotation) {
  const Mesh mesh = Bumpy(1);
  PointsX3 mirrored = mesh.points;
  mirrored.col(0) *= -1;
  EXPECT_GT(
      AlignGlobally(mesh, mesh, mesh.points, mirrored).target_from_source.rotation.determinant(),
      0.999);
}

TEST(SpreadRank, TellsPointLinePlaneAndSpace) {
  PointsX3 p(4, 3);
  p << 0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0;
  EXPECT_EQ(SpreadRank(p), 1);
  p(3, 1) = 2;
  EXPECT_EQ(SpreadRank(p), 2);
  p(1, 2) = 2;
  EXPECT_EQ(SpreadRank(p), 3);
  EXPECT_EQ(SpreadRank(PointsX3::Zero(3, 3)), 0);
}

}  // namespace keypose::registration::alignment_test
