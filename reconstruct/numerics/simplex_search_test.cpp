#include "reconstruct/numerics/simplex_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace keypose::reconstruct::simplex_search_test {

using Eigen::Vector2d;

TEST(MinimizeSimplex, FindsTheBananaValleysEnd) {
  const auto banana = [](const Eigen::VectorXd& x) {
    return 100 * std::pow(x(1) - x(0) * x(0), 2) + std::pow(1 - x(0), 2);
  };
  const Eigen::VectorXd x = MinimizeSimplex(banana, Vector2d(-1.2, 1), Vector2d(0.5, 0.5), 400);
  EXPECT_LT((x - Vector2d(1, 1)).norm(), 1e-3);
}

}  // namespace keypose::reconstruct::simplex_search_test
