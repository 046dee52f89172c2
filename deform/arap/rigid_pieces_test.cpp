#include "deform/arap/rigid_pieces.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "deform/arap/arap_fit.h"
#include "deform/arap/testing/random_matrix.h"

namespace keypose::rigid_pieces_test {

/// The largest trace(R^T m) that a proper rotation reaches, from the singular values.
double BestTrace(const Eigen::Matrix3d& m) {
  const Eigen::Vector3d s = Eigen::JacobiSVD<Eigen::Matrix3d>(m).singularValues();
  return s[0] + s[1] + (m.determinant() < 0 ? -s[2] : s[2]);
}

void ExpectNearestRotation(const Eigen::Matrix3d& m) {
  const Eigen::Matrix3d r = NearestRotation(m);
  EXPECT_LT((r * r.transpose() - Eigen::Matrix3d::Identity()).norm(), 1e-10) << m;
  EXPECT_NEAR(r.determinant(), 1, 1e-10) << m;
  EXPECT_NEAR((r.transpose() * m).trace(), BestTrace(m), 1e-10 * m.norm()) << m;
}

TEST(NearestRotation, ReachesTheLargestTraceOnRandomMirroredAndFlatMatrices) {
  std::mt19937 random(7);
  for (int k = 0; k < 2000; ++k) {
    const Eigen::Matrix3d m = RandomMatrix(random);
    ExpectNearestRotation(m);  // half of these are mirrored
    ExpectNearestRotation(1e-9 * m);
    ExpectNearestRotation(1e9 * m);
    Eigen::Matrix3d flat = m;
    flat.col(2) = 0.3 * m.col(0) - 0.7 * m.col(1);
    ExpectNearestRotation(flat);
    flat.col(2) += 1e-7 * m.col(1).cross(m.col(0));
    ExpectNearestRotation(flat);
  }
}

TEST(NearestRotation, OfNothingOrALineIsStillARotation) {
  Eigen::Matrix3d line = Eigen::Matrix3d::Zero();
  EXPECT_NEAR(NearestRotation(line).determinant(), 1, 1e-10);
  line.col(0) << 1, 2, 3;
  EXPECT_NEAR(NearestRotation(line).determinant(), 1, 1e-10);
  EXPECT_LT((NearestRotation(line).col(0) - line.col(0).normalized()).norm(), 1e-10);
}

TEST(NearestRotation, OfHalfATurnIsItself) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(M_PI, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  EXPECT_LT((NearestRotation(3 * turn) - turn).norm(), 1e-12);
}

}  // namespace keypose::rigid_pieces_test
