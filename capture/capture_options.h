// Options of keypose-capture.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "capture/board/board_choice.h"
#include "capture/board/board_words.h"
#include "capture/segmentation/mask_options.h"
#include "core/values/figure_strokes.h"
#include "core/values/options.h"

namespace keypose::capture {

struct CaptureOptions {
  int max_size = 0;  ///< longer side of the images written; 0 keeps the photographs' own
  int min_images = 8;
  double min_sharpness = 0.25;  ///< photographs of lower crispness count as blurred
  int sharpness_px = 1600;      ///< longer side at which sharpness is measured
  double min_mask = 0.002;      ///< masks of a smaller share of the image count as black
  double max_bad_share = 0.2;   ///< a larger share of blurred or black photographs stops the run
  int jpeg_quality = 96;        ///< for images that had to be turned or resized
  int mask_px = 512;            ///< longer side at which masks are segmented
  int mask_rounds = 4;
  double mask_smoothness = 12;
  double clean_plate_difference = 6;
  std::string board = "auto";  ///< "false", or as ParseBoard reads it
  int board_columns = BoardLayout{}.columns, board_rows = BoardLayout{}.rows;
  double board_square_mm = 1000 * BoardLayout{}.square_m;
  std::string board_page = "A4";
  std::string other_things = "leave_out";  ///< or "keep"
  std::string figure;                      ///< as ParseFigureStrokes reads it
  std::string leave_out;                   ///< as ParseLeftOut reads it

  bool LooksForBoard() const { return !SaysNo(board); }
  /// What was said of the board's squares and print; none: whatever the photographs show.
  std::optional<SaidBoard> Said() const {
    if (!SaysYes(board) && !SaysNo(board)) return ParseBoard(board);
    if (!SaysSquares()) return {};
    SaidBoard said;
    said.columns = board_columns;
    said.rows = board_rows;
    return said;
  }
  /// Whether the side of a square is what was measured.
  bool SaysSide() const {
    const std::optional<SaidBoard> said = Said();
    return (said && said->square_m > 0) || board_square_mm != CaptureOptions{}.board_square_mm;
  }
  BoardPattern Board() const {
    return PatternOf(Said().value_or(SaidBoard{}), board_square_mm / 1000);
  }

  bool KeepsOtherThings() const { return other_things == "keep"; }

  MaskOptions Masking() const {
    MaskOptions masking;
    masking.working_px = mask_px;
    masking.rounds = mask_rounds;
    masking.smoothness = mask_smoothness;
    masking.clean_plate_difference = clean_plate_difference;
    return masking;
  }

  void Describe(OptionVisitor& visit) {
    visit(
        "max_size", max_size,
        {"longer side of the images written; 0 keeps the photographs' size", "px", 0, 100000, {}});
    visit("min_images", min_images, {"fewer photographs than this are an error", "", 2, 10000, {}});
    visit("min_sharpness", min_sharpness,
          {"a photograph less crisp than this counts as blurred; 0 accepts all", "", 0, 1, {}});
    visit("max_bad_share", max_bad_share,
          {"largest share of blurred or black photographs in a set", "", 0, 1, {}});
    visit("clean_plate_difference", clean_plate_difference,
          {"colour difference to the clean plate at which object and set are equally likely",
           "CIE Lab",
           1,
           50,
           {}});
    visit(
        "board", board,
        {"the calibration board under the figure: auto: found in the photographs; false: none; or "
         "what it is, such as 8x11:22mm:DICT_4X4_50: columns, rows, side of a square, "
         "dictionary, and legacy for the layout of OpenCV before 4.6"});
    visit("board_columns", board_columns,
          {"squares along the board's longer side", "", 3, 100, {}});
    visit("board_rows", board_rows, {"squares along its shorter side", "", 3, 100, {}});
    visit("board_square_mm", board_square_mm,
          {"side of a square, as measured on the print", "mm", 2, 200, {}});
    visit("board_page", board_page,
          {"paper of --print-board", "", -INFINITY, INFINITY, {"A4", "A3", "letter"}});
    visit("other_things", other_things,
          {"photographs of another thing, up to a quarter",
           "",
           -INFINITY,
           INFINITY,
           {"leave_out", "keep"}});
    visit("figure", figure, {kFigureHelp});
    visit("leave_out", leave_out,
          {"photographs that are not read, by name, with ; between them; they stay in the folder"});
  }
  std::vector<std::string> Problems() const {
    std::vector<std::string> problems = BoardWordProblems(board);
    if (problems.empty() && SaysSquares() && !SaysYes(board) && !SaysNo(board))
      problems.push_back("--board says the squares: leave out board_columns and board_rows");
    if (problems.empty()) problems = Board().Problems();
    for (std::string& problem : FigureTextProblems(figure)) problems.push_back(std::move(problem));
    return problems;
  }

 private:
  bool SaysSquares() const {
    return board_columns != BoardLayout{}.columns || board_rows != BoardLayout{}.rows;
  }
};

}  // namespace keypose::capture
