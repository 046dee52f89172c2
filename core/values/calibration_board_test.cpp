#include "core/values/calibration_board.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace keypose::calibration_board_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

TEST(BoardLayout, CornersAreCentredAndRunFromTheTopLeft) {
  const BoardLayout board;
  ASSERT_EQ(board.CornerCount(), 70);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int id = 0; id < board.CornerCount(); ++id) sum += board.Corner(id);
  EXPECT_LT(sum.norm(), 1e-14);
  EXPECT_LT((board.Corner(0) - Eigen::Vector3d(-4.5 * 0.022, 3 * 0.022, 0)).norm(), 1e-15);
  EXPECT_LT((board.Corner(1) - board.Corner(0) - Eigen::Vector3d(0.022, 0, 0)).norm(), 1e-15);
  EXPECT_TRUE(board.Problems().empty());
}

TEST(BoardLayout, SquaresAndSizesHaveLimitsAndMarkersAreNotCounted) {
  const auto problems = [](const BoardLayout& layout) { return layout.Problems(); };
  EXPECT_THAT(problems({15, 15, 0.02, 0.015}), IsEmpty()) << "which dictionary has 112 markers?";
  EXPECT_THAT(problems({200, 200, 0.02, 0.015}), IsEmpty());
  EXPECT_THAT(problems({201, 5, 0.02, 0.015}),
              ElementsAre(HasSubstr("at most 200 squares along a side, not 201 x 5")));
  EXPECT_THAT(problems({3, 2, 0.02, 0.015}),
              ElementsAre(HasSubstr("at least 3 x 3 squares, not 3 x 2")));
  EXPECT_THAT(problems({11, 8, 0.02, 0.02}), ElementsAre(HasSubstr("smaller than its squares")));
  EXPECT_THAT(problems({11, 8, 0, 0.015}).size(), 2);
}

}  // namespace keypose::calibration_board_test
