// Epipolar geometry of two calibrated views.
#pragma once

#include <Eigen/Core>

namespace keypose::reconstruct {

/// Squared Sampson distance of a match from its epipolar lines; rays with z = 1.
inline double SquaredSampson(const Eigen::Matrix3d& e, const Eigen::Vector3d& x,
                             const Eigen::Vector3d& y) {
  const Eigen::Vector3d line = e * x;
  const double residual = y.dot(line);
  return residual * residual /
         (line.head<2>().squaredNorm() + (e.transpose() * y).head<2>().squaredNorm() + 1e-300);
}

/// The matrix E with y^T E x = 0 for rays x of the first and y of the second view, whose poses
/// (view from world) are given.
inline Eigen::Matrix3d EssentialOf(const Eigen::Matrix3d& r1, const Eigen::Vector3d& t1,
                                   const Eigen::Matrix3d& r2, const Eigen::Vector3d& t2) {
  const Eigen::Matrix3d r = r2 * r1.transpose();
  const Eigen::Vector3d t = t2 - r * t1;
  Eigen::Matrix3d cross;
  cross << 0, -t.z(), t.y(), t.z(), 0, -t.x(), -t.y(), t.x(), 0;
  return cross * r;
}

}  // namespace keypose::reconstruct
