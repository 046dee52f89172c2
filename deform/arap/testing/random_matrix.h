// Matrices for tests of rotations.
#pragma once

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <random>

namespace keypose {

inline Eigen::Matrix3d RandomMatrix(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  Eigen::Matrix3d m;
  for (int k = 0; k < 9; ++k) m(k / 3, k % 3) = uniform(random);
  return m;
}

}  // namespace keypose
