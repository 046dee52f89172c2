#include "capture/board/board_pattern.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "core/values/errors.h"

namespace keypose::capture::board_pattern_test {

BoardPattern Checkerboard(int columns, int rows) {
  BoardPattern board;
  board.kind = BoardPattern::Kind::kCheckerboard;
  board.layout.columns = columns;
  board.layout.rows = rows;
  return board;
}

TEST(BoardPattern, MarkersLieInTheWhiteSquaresOneEach) {
  for (const bool first_white : {false, true}) {
    BoardPattern board;
    board.layout.columns = 7;
    board.layout.rows = 5;
    board.first_white = first_white;
    EXPECT_EQ(board.MarkerCount(), first_white ? 18 : 17);
    std::set<std::pair<int, int>> squares;
    for (int m = 0; m < board.MarkerCount(); ++m) {
      const auto [column, row] = board.SquareOf(m);
      EXPECT_EQ((column + row) % 2 == 0, first_white) << m;
      EXPECT_LT(column, 7);
      EXPECT_LT(row, 5);
      squares.insert({column, row});
    }
    EXPECT_EQ(static_cast<int>(squares.size()), board.MarkerCount());
  }
}

TEST(BoardPattern, ACheckerboardLooksTheSameAfterSomeTurns) {
  EXPECT_EQ(BoardPattern().Turns(), 1);  // markers tell
  EXPECT_EQ(Checkerboard(10, 7).Turns(), 1);
  EXPECT_EQ(Checkerboard(10, 8).Turns(), 2);
  EXPECT_EQ(Checkerboard(8, 8).Turns(), 2);
  EXPECT_EQ(Checkerboard(7, 7).Turns(), 4);
}

TEST(BoardPattern, ABoardOfTwoRowsIsNamedAsAFault) {
  EXPECT_TRUE(Checkerboard(9, 6).Problems().empty());
  EXPECT_EQ(Checkerboard(9, 2).Problems().size(), 1u);
  EXPECT_TRUE(Checkerboard(100, 100).Problems().empty()) << "it has no markers to run out of";
}

TEST(SmallestDictionary, HoldsAsManyMarkersAsTheBoardHas) {
  ASSERT_EQ(DictionaryName(kOwnDictionary), "DICT_5X5_100");
  constexpr int kLargest = kOwnDictionary + 2;
  EXPECT_EQ(DictionaryName(SmallestDictionary(kLargest, 50)), "DICT_5X5_50");
  EXPECT_EQ(DictionaryName(SmallestDictionary(kLargest, 51)), "DICT_5X5_100");
  EXPECT_EQ(DictionaryName(SmallestDictionary(kLargest, 251)), "DICT_5X5_1000");
}

TEST(MarkerInk, HasABlackBorderAroundItsBits) {
  const auto ink = MarkerInk(kOwnDictionary, 3);
  ASSERT_EQ(ink.size(), 7u);
  int white = 0;
  for (int r = 0; r < 7; ++r)
    for (int c = 0; c < 7; ++c) {
      if (r == 0 || c == 0 || r == 6 || c == 6) {
        EXPECT_EQ(ink[r][c], 1);
      }
      white += ink[r][c] == 0;
    }
  EXPECT_GT(white, 0);
}

}  // namespace keypose::capture::board_pattern_test
