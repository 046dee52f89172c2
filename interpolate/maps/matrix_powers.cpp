#include "interpolate/maps/matrix_powers.h"

#include <Eigen/LU>
#include <cmath>

namespace keypose::interpolation {

namespace {

constexpr int kMostRoots = 12;
constexpr double kSeriesReach = 2;  // beyond it, terms exceed the sum and digits are lost
constexpr double kNearIdentity = 0.1;
constexpr double kExact = 1e-11;  // of the matrix's norm: largest error of exp(log(m))

std::optional<Eigen::Matrix3d> SquareRoot(const Eigen::Matrix3d& m) {
  Eigen::Matrix3d x = m, y = Eigen::Matrix3d::Identity();
  for (int round = 0; round < 30; ++round) {
    // Scaled by determinants (Higham 1997): maps far from the identity would need many halvings.
    const double scale =
        round < 6 ? std::pow(std::abs(x.determinant() * y.determinant()), -1.0 / 6) : 1;
    if (!std::isfinite(scale)) return std::nullopt;
    const Eigen::Matrix3d next = 0.5 * (scale * x + y.inverse() / scale),
                          other = 0.5 * (scale * y + x.inverse() / scale);
    const double change = (next - x).norm();
    x = next;
    y = other;
    if (!x.allFinite()) return std::nullopt;
    if (round > 2 && change < 1e-15 * x.norm()) break;
  }
  return x;
}

}  // namespace

std::optional<Eigen::Matrix3d> LogOfMatrix(const Eigen::Matrix3d& m) {
  if (!(m.determinant() > 0)) return std::nullopt;
  const Eigen::Matrix3d identity = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d root = m;
  int roots = 0;
  while ((root - identity).norm() > kNearIdentity) {
    if (++roots > kMostRoots) return std::nullopt;
    const std::optional<Eigen::Matrix3d> next = SquareRoot(root);
    if (!next) return std::nullopt;
    root = *next;
  }
  // log A = 2 artanh Z with Z = (A - I)(A + I)^-1, |Z| < 0.06.
  const Eigen::Matrix3d z = (root - identity) * (root + identity).inverse(), zz = z * z;
  Eigen::Matrix3d sum = identity / 15;
  for (int k = 13; k >= 1; k -= 2) sum = identity / k + zz * sum;
  const Eigen::Matrix3d log = std::ldexp(2.0, roots) * (z * sum);
  if (!((ExpOfMatrix(log) - m).norm() <= kExact * m.norm())) return std::nullopt;
  return log;
}

Eigen::Matrix3d ExpOfMatrix(const Eigen::Matrix3d& m) {
  const double size = m.cwiseAbs().rowwise().sum().maxCoeff();
  const int squarings = size > 0.125 ? std::ilogb(size) + 4 : 0;
  const Eigen::Matrix3d x = std::ldexp(1.0, -squarings) * m, identity = Eigen::Matrix3d::Identity();
  // Degree 9: |x| <= 1/8, so the truncation error is below 1e-15.
  const Eigen::Matrix3d x2 = x * x, x3 = x2 * x;
  const Eigen::Matrix3d high = identity / 720 + x / 5040 + x2 / 40320 + x3 / 362880;
  const Eigen::Matrix3d middle = identity / 6 + x / 24 + x2 / 120 + x3 * high;
  Eigen::Matrix3d sum = identity + x + x2 / 2 + x3 * middle;
  for (int k = 0; k < squarings; ++k) sum = (sum * sum).eval();
  return sum;
}

MatrixExponential::MatrixExponential(const Eigen::Matrix3d& m)
    : m_(m),
      mm_(m * m),
      trace_(m.trace()),
      minors_(0.5 * (trace_ * trace_ - mm_.trace())),
      determinant_(m.determinant()),
      size_(m.cwiseAbs().rowwise().sum().maxCoeff()) {}

Eigen::Matrix3d MatrixExponential::At(double t) const {
  const double size = std::abs(t) * size_;
  if (size > kSeriesReach) return ExpOfMatrix(t * m_);
  // (tM)^n / n! = a M^2 + b M + c I.
  double a = 0, b = 0, c = 1, sum_a = 0, sum_b = 0, sum_c = 1, left = 1;
  for (int n = 1; left > 1e-18; ++n) {
    const double share = t / n, next_a = share * (a * trace_ + b),
                 next_b = share * (c - a * minors_);
    c = share * a * determinant_;
    a = next_a;
    b = next_b;
    sum_a += a;
    sum_b += b;
    sum_c += c;
    left *= size / n;
  }
  return sum_a * mm_ + sum_b * m_ + sum_c * Eigen::Matrix3d::Identity();
}

}  // namespace keypose::interpolation
