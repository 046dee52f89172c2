#include "motion/reconstruct/point_moves.h"

#include <gtest/gtest.h>

namespace keypose::motion::point_moves_test {

TEST(MovePoints, AddsStepsOfPartsAndPulls) {
  // Of nine points the last is not one of four.
  const Eigen::Matrix<double, Eigen::Dynamic, 3> field =
      Eigen::Matrix<double, Eigen::Dynamic, 3>::Random(9, 3);
  const Eigen::MatrixXd columns = Eigen::MatrixXd::Random(9, 3);
  const std::vector<int> parts = {0, 0, 0, 1, 1, 0, 1, 1, 1};
  const std::vector<double> along = {0.5, -2};
  const std::vector<int> pulled = {2, 0};
  const Eigen::MatrixXd pulls = Eigen::MatrixXd::Random(2, 3);
  PointsX3 points = PointsX3::Random(9, 3), expected = points;
  double largest = 0;
  for (int i = 0; i < 9; ++i) {
    const Eigen::RowVector3d moved = columns(i, 2) * pulls.row(0) + columns(i, 0) * pulls.row(1);
    largest = std::max(largest, moved.norm());
    expected.row(i) += moved + along[parts[i]] * field.row(i);
  }
  EXPECT_NEAR(MovePoints({&field, &parts, &along, &columns, pulled, pulls}, points), largest,
              1e-15);
  EXPECT_LT((points - expected).cwiseAbs().maxCoeff(), 1e-15);
}

}  // namespace keypose::motion::point_moves_test
