#include "core/values/motion_clip.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/values/angles.h"

namespace keypose::motion_clip_test {

TEST(EulerZyx, RotatesBack) {
  for (const double y : {-90.0, -40.0, 0.0, 75.0, 90.0}) {
    const Eigen::Matrix3d r = (Eigen::AngleAxisd(130 * kDegree, Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(y * kDegree, Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(-70 * kDegree, Eigen::Vector3d::UnitX()))
                                  .toRotationMatrix();
    const Eigen::Vector3d a = EulerZyx(r);
    const Eigen::Matrix3d back = (Eigen::AngleAxisd(a[0], Eigen::Vector3d::UnitZ()) *
                                  Eigen::AngleAxisd(a[1], Eigen::Vector3d::UnitY()) *
                                  Eigen::AngleAxisd(a[2], Eigen::Vector3d::UnitX()))
                                     .toRotationMatrix();
    EXPECT_LT((back - r).norm(), 1e-7) << y;
  }
}

}  // namespace keypose::motion_clip_test
