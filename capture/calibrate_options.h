// The options of keypose-calibrate.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "capture/board/board_survey.h"
#include "capture/board/board_words.h"
#include "core/values/options.h"
#include "views/shot/clock_wish.h"

namespace keypose::capture {

struct CalibrateOptions {
  std::string board = "auto";
  int board_columns = 0, board_rows = 0;
  double board_square_mm = 1000 * BoardLayout{}.square_m;
  int every = 5;
  int floor_frame = 0;
  std::string clock_offsets = "auto";

  /// What was said of a ChArUco board in one word; none: it is to be found.
  std::optional<SaidBoard> Said() const {
    if (board == "charuco" || board == "checkerboard" || SaysYes(board)) return {};
    return ParseBoard(board);
  }
  /// Whether the side of a square is what was measured.
  bool SaysSide() const {
    const std::optional<SaidBoard> said = Said();
    return (said && said->square_m > 0) || board_square_mm != CalibrateOptions{}.board_square_mm;
  }
  BoardWish Wish() const {
    BoardWish wish;
    if (board == "charuco" || Said()) wish.kind = BoardPattern::Kind::kCharuco;
    if (board == "checkerboard") wish.kind = BoardPattern::Kind::kCheckerboard;
    wish.columns = board_columns;
    wish.rows = board_rows;
    wish.square_m = board_square_mm / 1000;
    wish.own_completed = !Said();
    return wish;
  }
  void Describe(OptionVisitor& visit) {
    visit("board", board,
          {"what is printed on the board: auto: found in the pictures; charuco; checkerboard; or a "
           "ChArUco board in full, such as 8x11:22mm:DICT_4X4_50: columns, rows, side of a square, "
           "dictionary, and legacy for the layout of OpenCV before 4.6"});
    visit("board_columns", board_columns,
          {"squares along the board's one side, where they are not found in the pictures; a "
           "checkerboard of 7 x 4 inner corners has 8 x 5; 0: found",
           "",
           0,
           100,
           {}});
    visit("board_rows", board_rows, {"squares along its other side; 0: found", "", 0, 100, {}});
    visit("board_square_mm", board_square_mm,
          {"side of a square, as measured on the print", "mm", 2, 500, {}});
    visit("every", every, {"only every so many frames are looked at", "frames", 1, 1000, {}});
    visit("floor_frame", floor_frame,
          {"the frame in which the board lies on the floor: it becomes z = 0 and the origin",
           "",
           0,
           1e6,
           {}});
    visit("clock_offsets", clock_offsets, {.help = kClockOffsetsHelp});
  }
  std::vector<std::string> Problems() const {
    if (const auto problems = ClockWishProblems(clock_offsets); !problems.empty()) return problems;
    if (board != "charuco" && board != "checkerboard") {
      if (SaysNo(board)) return {"--board says what the board is; calibrate needs one"};
      if (const auto problems = BoardWordProblems(board); !problems.empty()) return problems;
      if (Said() && board_columns != 0)
        return {"--board says the squares: leave out board_columns and board_rows"};
    }
    if ((board_columns == 0) != (board_rows == 0))
      return {"board_columns and board_rows belong together: give both, or none"};
    if (board_columns == 0) return {};
    BoardPattern pattern;
    pattern.kind = BoardPattern::Kind::kCheckerboard;
    pattern.layout.columns = board_columns;
    pattern.layout.rows = board_rows;
    return pattern.Problems();
  }
};

}  // namespace keypose::capture
