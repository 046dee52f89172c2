#include "fit/following/followed_mesh.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"
#include "fit/following/frame_fit.h"

namespace keypose::fit::followed_mesh_test {

using Eigen::Vector3d;

TEST(FollowedMesh, OffsetsTurnWithTheSurface) {
  const Mesh mesh = MakeCylinder(0.3, 2, 16, 12);
  const FollowedMesh followed(mesh.points, mesh.faces, 5000);
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.5, Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  const PointsX3 turned = mesh.points * turn.transpose();
  for (const Eigen::Matrix3d& found : followed.TurnsOf(turned))
    EXPECT_LT((found - turn).norm(), 1e-9);
  const PointsX3 offsets = 0.1 * mesh.points;
  EXPECT_LT((Bent(followed, turned, offsets).points - 1.1 * turned).norm(), 1e-9);
}

}  // namespace keypose::fit::followed_mesh_test
