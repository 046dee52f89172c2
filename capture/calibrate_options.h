// The options of keypose-calibrate.
#pragma once

#include <string>
#include <vector>

#include "capture/board/board_survey.h"
#include "core/values/options.h"

namespace keypose::capture {

struct CalibrateOptions {
  std::string board = "auto";
  int board_columns = 0, board_rows = 0;
  double board_square_mm = 1000 * BoardLayout{}.square_m;
  int every = 5;
  int floor_frame = 0;

  BoardWish Wish() const {
    BoardWish wish;
    if (board == "charuco") wish.kind = BoardPattern::Kind::kCharuco;
    if (board == "checkerboard") wish.kind = BoardPattern::Kind::kCheckerboard;
    wish.columns = board_columns;
    wish.rows = board_rows;
    wish.square_m = board_square_mm / 1000;
    return wish;
  }
  void Describe(OptionVisitor& visit) {
    visit("board", board,
          {.help = "what is printed on the board; auto: found in the pictures",
           .choices = {"auto", "charuco", "checkerboard"}});
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
  }
  std::vector<std::string> Problems() const {
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
