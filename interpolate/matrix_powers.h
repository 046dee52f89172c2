// Powers of 3x3 matrices that are near enough to the identity to have one.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace keypose::interpolation {

/// The real logarithm nearest to zero; nothing where there is none or it cannot be found safely (eigenvalues near the negative axis).
/// Source: inverse scaling and squaring, Kenney and Laub 1989; square roots by Denman and Beavers 1976.
std::optional<Eigen::Matrix3d> LogOfMatrix(const Eigen::Matrix3d& m);

/// exp(m), by scaling, a Taylor polynomial, and squaring.
Eigen::Matrix3d ExpOfMatrix(const Eigen::Matrix3d& m);

}  // namespace keypose::interpolation
