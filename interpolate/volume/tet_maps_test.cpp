#include "interpolate/volume/tet_maps.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace keypose::interpolation::tet_maps_test {

TEST(ClosestRotation, EqualsSingularValuesAlsoForMirroredAndFlatMaps) {
  for (int k = 0; k < 2000; ++k) {
    const auto wave = [&](double f) { return std::sin(f * (k + 1)); };
    Eigen::Matrix3d j;
    j << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(Eigen::MatrixXd(j),
                                                Eigen::ComputeFullU | Eigen::ComputeFullV);
    if (svd.singularValues()[1] - svd.singularValues()[2] < 1e-3)
      continue;  // not unique for a mirrored one
    Eigen::Vector3d sign = Eigen::Vector3d::Ones();
    sign[2] = (svd.matrixU() * svd.matrixV()).determinant() > 0 ? 1 : -1;
    EXPECT_LT(
        (ClosestRotation(j) - svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose()).norm(),
        1e-10);
  }
  EXPECT_LT(
      (ClosestRotation(Eigen::Vector3d(2, 3, 0).asDiagonal()) - Eigen::Matrix3d::Identity()).norm(),
      1e-12);
}

}  // namespace keypose::interpolation::tet_maps_test
