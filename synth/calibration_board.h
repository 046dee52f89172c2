// The ChArUco calibration board that may lie under the character.
#pragma once

#include "core/calibration_board.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::synth {

/// The calibration board under the character.
struct BoardOptions {
  bool charuco = false;
  int squares_x = BoardLayout{}.columns,
      squares_y = BoardLayout{}.rows;  ///< the board that capture prints
  double square_m = BoardLayout{}.square_m;
  double marker_m = BoardLayout{}.marker_m;
};

/// A board of OpenCV's DICT_5X5_100 in the plane z = 0, centred on the axis; x to the right and y
/// up when seen from above.
struct BoardPicture {
  Image8 picture;  ///< grey, first row at +y; covers width_m x height_m
  double width_m = 0, height_m = 0;
  double border_m = 0;  ///< white card round the board
  PointsX3 corners;     ///< inner chessboard corners in OpenCV's order of ids, in world [m], z = 0
};

/// @throws UsageError  marker not smaller than the square, or more markers than the dictionary has
BoardPicture MakeBoardPicture(const BoardOptions& options);

}  // namespace keypose::synth
