#include "capture/board/print_seen.h"

#include <gtest/gtest.h>

namespace keypose::capture::print_seen_test {

TEST(PrintSeen, IsTheBoardWithoutWhatStandsOnItAndWithoutSinglePixels) {
  constexpr int kSide = 60;
  BoardOdds board{Image8(kSide, kSide, 1, 0), ImageF(kSide, kSide, 1)};
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      if (x < 10) continue;  // beside the board
      *board.on_board.at(x, y) = 255;
      const bool figure = x >= 30 && x < 45 && y >= 20 && y < 50;
      *board.odds.at(x, y) = figure ? 3.0F : -3.0F;
    }
  *board.odds.at(20, 10) = 3;   // noise on the print
  *board.odds.at(37, 35) = -3;  // a spot of the figure that is like it
  const Image8 print = PrintSeen(board);
  EXPECT_EQ(*print.at(5, 30), 0);
  EXPECT_EQ(*print.at(20, 10), 255);
  EXPECT_EQ(*print.at(37, 35), 0);
  EXPECT_EQ(*print.at(52, 40), 255);
  EXPECT_EQ(*print.at(32, 30), 0);
  EXPECT_TRUE(PrintSeen({}).empty());
}

}  // namespace keypose::capture::print_seen_test
