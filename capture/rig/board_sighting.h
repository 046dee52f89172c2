// The calibration board as one camera saw it at one moment.
#pragma once

#include <vector>

#include "core/values/calibration_board.h"

namespace keypose::capture {

struct BoardSighting {
  int camera = 0, frame = 0;
  std::vector<BoardCorner> corners;
  /// Part of a checkerboard, numbered from any corner: good for the lens, not for the place.
  bool partial = false;
};

}  // namespace keypose::capture
