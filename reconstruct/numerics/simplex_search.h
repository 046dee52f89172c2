// Minimum of a non-smooth function of a few variables: the simplex search.
#pragma once

#include <Eigen/Core>
#include <functional>

namespace keypose::reconstruct {

/// The best point found from `start`; `step` is the size of the first simplex along each axis.
/// Never worse than `start`.
/// Source: Nelder & Mead, The Computer Journal 1965, with the usual coefficients 1, 2, 1/2, 1/2.
Eigen::VectorXd MinimizeSimplex(const std::function<double(const Eigen::VectorXd&)>& cost,
                                const Eigen::VectorXd& start, const Eigen::VectorXd& step,
                                int max_evaluations);

}  // namespace keypose::reconstruct
