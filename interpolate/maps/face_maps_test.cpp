#include "interpolate/maps/face_maps.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>

namespace keypose::interpolation::face_maps_test {

TEST(PolarOf, EqualsSingularValueDecompositionOnTenThousandTriangles) {
  double worst = 0;
  for (int k = 0; k < 10000; ++k) {
    const auto wave = [&](double f) { return std::sin(f * (k + 1)); };
    Eigen::Matrix2d j;
    j << 1.05 + wave(1.1), 2 * wave(2.3), 0,
        1.02 + wave(3.7);  // a ratio of upper triangular matrices has a positive diagonal
    const Eigen::Matrix2d turn = Eigen::Rotation2Dd(3 * wave(0.7)).toRotationMatrix();
    j = (turn * j).eval();
    const Eigen::JacobiSVD<Eigen::Matrix2d> svd(j, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const Polar2 polar = PolarOf(j);
    Eigen::Matrix2d rotation;
    rotation << polar.cosine, -polar.sine, polar.sine, polar.cosine;
    worst = std::max(worst,
                     (rotation - svd.matrixU() * svd.matrixV().transpose()).cwiseAbs().maxCoeff());
    worst = std::max(worst, (rotation * polar.stretch - j).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(worst, 1e-12);
}

}  // namespace keypose::interpolation::face_maps_test
