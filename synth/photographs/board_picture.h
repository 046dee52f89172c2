// The ChArUco calibration board under the character.
#pragma once

#include <string>

#include "core/values/board_print.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// Size and layout of the calibration board.
struct BoardOptions {
  bool charuco = false;
  int squares_x = BoardLayout{}.columns,
      squares_y = BoardLayout{}.rows;  ///< the board that capture prints
  double square_m = BoardLayout{}.square_m;
  double marker_m = BoardLayout{}.marker_m;
  BoardPrint print;

  BoardLayout Layout() const { return {squares_x, squares_y, square_m, marker_m}; }
  /// As ParseBoard reads it; what is not said stays as it is.
  /// @throws UsageError
  void Say(const std::string& text);
};

/// A board with OpenCV's markers in the plane z = 0, centred on the axis; x to the right and y
/// up when seen from above.
struct BoardPicture {
  Image8 picture;  ///< grey, first row at +y; covers width_m x height_m
  double width_m = 0, height_m = 0;
  double border_m = 0;  ///< white margin around the board
  PointsX3 corners;     ///< inner chessboard corners in OpenCV's order of ids, in world [m], z = 0
};

/// @throws UsageError  a marker is not smaller than its square, or the dictionary has too few
/// markers
BoardPicture MakeBoardPicture(const BoardOptions& options);

}  // namespace keypose::synth
