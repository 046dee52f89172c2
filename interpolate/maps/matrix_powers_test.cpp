#include "interpolate/maps/matrix_powers.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <optional>

#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation::matrix_powers_test {

TEST(LogOfMatrix, IsTheInverseOfTheExponentialAndKnowsShears) {
  for (int k = 0; k < 500; ++k) {
    const auto wave = [&](double f) { return 0.8 * std::sin(f * (k + 1)); };
    Eigen::Matrix3d log;
    log << wave(1.1), wave(2.3), wave(3.7), wave(0.9), wave(5.1), wave(1.7), wave(2.9), wave(4.3),
        wave(0.7);
    const std::optional<Eigen::Matrix3d> back = LogOfMatrix(ExpOfMatrix(log));
    ASSERT_TRUE(back.has_value());
    EXPECT_LT((*back - log).norm(), 1e-11);
    for (double t : {-1.3, 0.1, 0.7, 3.0})
      EXPECT_LT((MatrixExponential(log).At(t) - ExpOfMatrix(t * log)).norm(),
                1e-13 * ExpOfMatrix(t * log).norm());
  }
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 2) = 5;
  EXPECT_LT((*LogOfMatrix(shear) - (shear - Eigen::Matrix3d::Identity())).norm(), 1e-12);
  EXPECT_FALSE(LogOfMatrix(-Eigen::Matrix3d::Identity()).has_value());
}

TEST(PowerOf, HalfPowerSquaredIsTheMatrix) {
  Eigen::Matrix2d m;
  m << 2, 0.4, 0.4, 0.6;
  EXPECT_LT((PowerOf(m, 0.5) * PowerOf(m, 0.5) - m).norm(), 1e-14);
  EXPECT_LT((PowerOf(m, 0) - Eigen::Matrix2d::Identity()).norm(), 1e-14);
  EXPECT_LT((PowerOf(m, 1) - m).norm(), 1e-14);
}

}  // namespace keypose::interpolation::matrix_powers_test
