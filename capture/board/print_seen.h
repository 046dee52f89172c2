// Where a photograph shows the board's print.
#pragma once

#include "capture/board/board_detection.h"
#include "core/values/image.h"

namespace keypose::capture {

/// 255 where the print shows, which tells nothing of the figure that stands on it: on the board,
/// where the photograph is as expected. Single pixels count neither way.
/// @return of the odds' size; empty where no board is known
Image8 PrintSeen(const BoardOdds& board);

}  // namespace keypose::capture
