#include "core/numbers/kd_tree.h"

#include <gtest/gtest.h>

namespace keypose::kd_tree_test {

TEST(KdTree, FindsWhatBruteForceFinds) {
  const PointsX3 points = PointsX3::Random(500, 3);
  const KdTree tree(points);
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Vector3d p = Eigen::Vector3d::Random();
    Eigen::Index best = 0;
    (points.rowwise() - p.transpose()).rowwise().squaredNorm().minCoeff(&best);
    EXPECT_EQ(tree.Nearest(p).index, best);
    EXPECT_EQ(tree.Nearest(p, 5).front().index, best);
    const auto within = tree.Within(p, 0.5);
    EXPECT_EQ(std::ssize(within),
              ((points.rowwise() - p.transpose()).rowwise().norm().array() < 0.5).count());
  }
}

}  // namespace keypose::kd_tree_test
