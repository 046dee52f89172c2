// Planes that turn before a tripod, from matches at wrong turns.
#include "reconstruct/surroundings/turning_plane.h"

#include <gtest/gtest.h>

#include "core/values/angles.h"
#include "reconstruct/surroundings/testing/cameras_over_plane.h"

namespace keypose::reconstruct::turning_plane_test {

/// From directions in a camera's frame to the plane z = 0 of the world, homogeneous.
Eigen::Matrix3d PlaneFromDirections(const Rigid3& camera_from_world) {
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  Eigen::Matrix3d directions;
  directions << rotation.col(0), rotation.col(1), camera_from_world.translation;
  return directions.inverse();
}

/// Of directions, when the plane turns round the world's z axis.
Eigen::Matrix3d TurnSeenBy(const View& view, double turn) {
  const Eigen::Matrix3d plane = PlaneFromDirections(view.camera_from_world);
  return plane.inverse() * Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix() * plane;
}

TEST(PlaneOfTurn, IsToldByAnyTurn) {
  const View view = From(4, 30 * kDegree, 0.3, "a");
  for (const double degrees : {-150.0, -40.0, 20.0, 90.0, 170.0}) {
    const auto plane = PlaneOfTurn(-2.5 * TurnSeenBy(view, degrees * kDegree));
    ASSERT_TRUE(plane) << degrees;
    const Rigid3& pose = view.camera_from_world;
    EXPECT_LT((plane->middle - pose.translation.normalized()).norm(), 1e-9) << degrees;
    EXPECT_LT((plane->normal - pose.rotation * Vector3d::UnitZ()).norm(), 1e-9) << degrees;
    EXPECT_NEAR(*RadiusOnPlane(*plane, pose * Vector3d(0.3, 0.4, 0)), 0.5 / 4, 1e-9);
  }
}

TEST(PlaneOfTurn, OtherMotionsAreNone) {
  const View view = From(4, 30 * kDegree, 0.3, "a");
  EXPECT_FALSE(PlaneOfTurn(Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(PlaneOfTurn(Eigen::Matrix3d::Zero()));
  EXPECT_FALSE(PlaneOfTurn(TurnSeenBy(view, 1 * kDegree))) << "hardly turned";
  const Eigen::Matrix3d plane = PlaneFromDirections(view.camera_from_world);
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 1) = 0.8, shear(1, 0) = -0.1, shear(0, 2) = 0.3;
  EXPECT_FALSE(PlaneOfTurn(plane.inverse() * shear * plane)) << "no turn of the plane";
}

TEST(CameraOver, SeesThePlaneSo) {
  const View view = From(4, 30 * kDegree, 0, "a");
  const auto plane = PlaneOfTurn(TurnSeenBy(view, 1));
  ASSERT_TRUE(plane);
  const Rigid3 over = CameraOver(*plane, 4);
  EXPECT_LT((over.translation - view.camera_from_world.translation).norm(), 1e-9);
  EXPECT_LT(over.rotation.angularDistance(view.camera_from_world.rotation), 1e-9);
}

}  // namespace keypose::reconstruct::turning_plane_test
