// The calibration board as a page to print.
#pragma once

#include <string>
#include <vector>

#include "core/values/calibration_board.h"
#include "core/values/image.h"

namespace keypose::capture {

struct Page {
  std::string name;
  double width_mm = 0, height_mm = 0;  ///< landscape
};

/// A4, A3 or letter, landscape.
/// @throws UsageError  another name
Page PageNamed(const std::string& name);

/// The board as a vector PDF of one page: squares and markers in exact millimetres, a cross and a
/// circle in the middle, a ruler of 100 mm to check the printer's scale, and instructions. Same
/// bytes at every call.
/// @throws UsageError  the board is not valid, or does not fit on the page with its white rim;
/// names the largest possible squares
std::string BoardPdf(const BoardLayout& board, const Page& page);

/// The same page as grey pixels.
/// @throws UsageError  as BoardPdf
Image8 BoardPicture(const BoardLayout& board, const Page& page, double px_per_mm);

}  // namespace keypose::capture
