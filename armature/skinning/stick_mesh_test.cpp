#include "armature/skinning/stick_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include "armature/skinning/skin.h"
#include "armature/skinning/testing/two_bones.h"
#include "core/surfaces/geometry.h"
#include "core/values/errors.h"

namespace keypose::armature::stick_mesh_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

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

}  // namespace keypose::armature::stick_mesh_test
