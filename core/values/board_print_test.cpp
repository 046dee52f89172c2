#include "core/values/board_print.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/values/errors.h"

namespace keypose::board_print_test {

TEST(ParseBoard, SquaresSidesDictionaryAndLayoutAreRead) {
  const SaidBoard board = ParseBoard("8x12:22/16.5mm:dict_4x4_50:legacy");
  EXPECT_EQ(board.columns, 8);
  EXPECT_EQ(board.rows, 12);
  EXPECT_DOUBLE_EQ(board.square_m, 0.022);
  EXPECT_DOUBLE_EQ(board.marker_m, 0.0165);
  EXPECT_EQ(board.dictionary, 0);
  EXPECT_TRUE(board.legacy);
  EXPECT_EQ(board.FirstWhite(12), true);
  EXPECT_FALSE(board.inverted);
  EXPECT_EQ(ParseBoard("8x11:legacy").FirstWhite(11), false) << "odd rows were never changed";
  EXPECT_EQ(ParseBoard("8x11:first_white").FirstWhite(11), true);
  EXPECT_EQ(ParseBoard("8x11:first_white:legacy").FirstWhite(11), false);
  EXPECT_EQ(ParseBoard("8x11:legacy:first_white").FirstWhite(11), true);
  EXPECT_FALSE(ParseBoard("8x11").FirstWhite(11).has_value());
  EXPECT_EQ(ParseBoard("8x11:AprilTag_36h11:inverted").dictionary, 20);
  EXPECT_TRUE(ParseBoard("8x11:inverted").inverted);
  EXPECT_FALSE(ParseBoard("8x11").dictionary);
}

TEST(ParseBoard, WhatIsNoBoardIsAUsageErrorThatSaysHow) {
  for (const char* text : {"", "8", "8x", "ax9", "8x11:22", "8x11:0mm", "8x11:22/23mm", "8x11:6X6",
                           "2x9", "8x11:", "20x20:DICT_4X4_50", "8x11:22mm x"})
    EXPECT_THROW(ParseBoard(text), UsageError) << text;
  try {
    ParseBoard("12x8:22mm:DICT_APRILTAG_25h9");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(),
                ::testing::HasSubstr("more markers than the 35 of DICT_APRILTAG_25h9"));
  }
}

TEST(BoardText, SaysWhatParseBoardReads) {
  for (const char* text : {"8x11:22mm:DICT_4X4_50", "11x8:17.5mm:DICT_APRILTAG_36h11:legacy",
                           "5x7:30mm:DICT_6X6_250:first_white:inverted"}) {
    const SaidBoard said = ParseBoard(text);
    BoardPrint print;
    print.dictionary = *said.dictionary;
    print.first_white = said.FirstWhite(said.rows).value_or(false);
    print.inverted = said.inverted;
    EXPECT_EQ(BoardText({said.columns, said.rows, said.square_m, 0.7 * said.square_m}, print),
              text);
  }
}

TEST(SaidBoard, AllowsABoardWhoseLastRowsAreHiddenAndNoOther) {
  const SaidBoard said = ParseBoard("8x11:22mm:DICT_4X4_100");
  BoardPrint print;
  print.dictionary = 0;
  EXPECT_TRUE(said.Allows({8, 11, 0.022, 0.016}, print));
  EXPECT_TRUE(said.Allows({8, 9, 0.022, 0.016}, print));
  EXPECT_TRUE(said.Allows({11, 8, 0.022, 0.016}, print)) << "columns and rows exchanged";
  EXPECT_FALSE(said.Allows({9, 11, 0.022, 0.016}, print));
  EXPECT_FALSE(said.Allows({8, 12, 0.022, 0.016}, print));
  print.dictionary = kOwnDictionary;
  EXPECT_FALSE(said.Allows({8, 11, 0.022, 0.016}, print));
}

TEST(SaidBoard, TheLegacyLayoutGoesByTheRowsOfTheBoardThatIsSeen) {
  BoardPrint white, black;
  white.first_white = true;
  const SaidBoard ten_rows = ParseBoard("10x7:legacy"), eight_rows = ParseBoard("11x8:legacy");
  // 7 x 10 squares begin white, 10 x 7 black
  EXPECT_TRUE(ten_rows.Allows({7, 10, 0.022, 0.016}, white));
  EXPECT_FALSE(ten_rows.Allows({7, 10, 0.022, 0.016}, black));
  EXPECT_TRUE(ten_rows.Allows({10, 7, 0.022, 0.016}, black));
  EXPECT_FALSE(ten_rows.Allows({10, 7, 0.022, 0.016}, white));
  // 8 x 11 squares begin black, 11 x 8 white, also where the last row is hidden
  EXPECT_TRUE(eight_rows.Allows({8, 11, 0.022, 0.016}, black));
  EXPECT_FALSE(eight_rows.Allows({8, 11, 0.022, 0.016}, white));
  EXPECT_TRUE(eight_rows.Allows({11, 7, 0.022, 0.016}, white));
  EXPECT_FALSE(eight_rows.Allows({11, 7, 0.022, 0.016}, black));
}

TEST(BoardProblems, ADictionaryHasOnlySoManyMarkers) {
  BoardPrint print;
  print.dictionary = *DictionaryNamed("DICT_4X4_50");
  EXPECT_TRUE(BoardProblems({10, 10, 0.02, 0.015}, print).empty());
  EXPECT_EQ(BoardProblems({11, 10, 0.02, 0.015}, print).size(), 1u);
  EXPECT_EQ(BoardProblems({2, 10, 0.02, 0.015}, print).size(), 1u);
  EXPECT_EQ(BoardProblems({10, 10, 0.02, 0.02}, print).size(), 1u);
  EXPECT_EQ(BoardProblems({100000, 100000, 0.02, 0.015}, print).size(), 1u);
  // Keypose's own dictionary has 100 markers
  EXPECT_TRUE(BoardProblems({20, 10, 0.02, 0.015}, {}).empty());
  EXPECT_EQ(BoardProblems({15, 15, 0.02, 0.015}, {}).size(), 1u);
}

}  // namespace keypose::board_print_test
