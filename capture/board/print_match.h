// A ChArUco board found by its squares' corners, where its markers are too small to be found alone.
#pragma once

#include <vector>

#include "capture/board/board_pattern.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Corners of the board, numbered, to about a pixel.
///
/// The squares' corners give a grid; every place and turn of the grid on the board is compared with
/// the picture by the bits of all its markers together, which tells them apart where no marker can
/// be read for itself.
/// @param enlarged  how much larger the picture is made for the search of corners, >= 1
/// @return empty where no place agrees with the picture clearly better than the others
std::vector<BoardCorner> MatchPrint(const Image8& grey, const BoardPattern& pattern,
                                    double enlarged);

}  // namespace keypose::capture
