// Powers of 3x3 matrices that are close enough to the identity to have a real logarithm.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace keypose::interpolation {

/// The real logarithm nearest to zero. Nothing where none exists or where it cannot be found
/// reliably (eigenvalues near the negative axis).
/// Source: inverse scaling and squaring, Kenney and Laub 1989; square roots by Denman and Beavers
/// 1976.
std::optional<Eigen::Matrix3d> LogOfMatrix(const Eigen::Matrix3d& m);

/// exp(m), by scaling, a Taylor polynomial, and squaring.
Eigen::Matrix3d ExpOfMatrix(const Eigen::Matrix3d& m);

/// exp(t M) for many t. By Cayley and Hamilton it is a combination of I, M and M^2, so only three
/// coefficients of its Taylor series have to be summed.
class MatrixExponential {
 public:
  MatrixExponential() = default;
  explicit MatrixExponential(const Eigen::Matrix3d& m);
  Eigen::Matrix3d At(double t) const;

 private:
  Eigen::Matrix3d m_ = Eigen::Matrix3d::Zero(), mm_ = Eigen::Matrix3d::Zero();
  double trace_ = 0, minors_ = 0, determinant_ = 0;  ///< M^3 = trace M^2 - minors M + determinant I
  double size_ = 0;
};

}  // namespace keypose::interpolation
