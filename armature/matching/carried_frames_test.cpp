#include "armature/matching/carried_frames.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
namespace keypose::armature::carried_frames_test {

using Eigen::Quaterniond;
using Eigen::Vector3d;

TEST(TurnsAlong, PartsTakeTheMeanOfTheirPieces) {
  PointsX3 points = PointsX3::Zero(3, 3);
  points(1, 1) = 1, points(2, 1) = 2;
  const auto about_y = [](double angle) {
    return Quaterniond(Eigen::AngleAxisd(angle, Vector3d::UnitY()));
  };
  Quaterniond second = about_y(1);
  second.coeffs() *= -1;  // the same turn
  const auto turns = TurnsAlong(Polyline(points), {about_y(0), second}, Eigen::Vector3d(1, 2, 1));
  EXPECT_LT(turns[0].angularDistance(about_y(0)), 1e-9);
  EXPECT_LT(turns[1].angularDistance(about_y(0.5)), 1e-9);
  EXPECT_LT(turns[2].angularDistance(about_y(1)), 1e-9);
}

}  // namespace keypose::armature::carried_frames_test
