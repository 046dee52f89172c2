#include "core/values/calibration_board.h"

#include <gtest/gtest.h>

namespace keypose::calibration_board_test {

TEST(BoardLayout, CornersAreCentredAndRunFromTheTopLeft) {
  const BoardLayout board;
  ASSERT_EQ(board.CornerCount(), 70);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int id = 0; id < board.CornerCount(); ++id) sum += board.Corner(id);
  EXPECT_LT(sum.norm(), 1e-14);
  EXPECT_LT((board.Corner(0) - Eigen::Vector3d(-4.5 * 0.022, 3 * 0.022, 0)).norm(), 1e-15);
  EXPECT_LT((board.Corner(1) - board.Corner(0) - Eigen::Vector3d(0.022, 0, 0)).norm(), 1e-15);
  EXPECT_TRUE(board.Problems().empty());
  EXPECT_FALSE((BoardLayout{15, 15, 0.02, 0.015}.Problems().empty()));
  EXPECT_FALSE((BoardLayout{11, 8, 0.02, 0.02}.Problems().empty()));
}

}  // namespace keypose::calibration_board_test
