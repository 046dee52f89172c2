// Finds a plain checkerboard of any size in a picture.
#pragma once

#include <vector>

#include "core/values/calibration_board.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Inner corners of a checkerboard, as far as they are seen. Columns run along the longer side;
/// seen from the front, rows run down where columns run to the right.
struct CheckerGrid {
  struct Corner {
    int column = 0, row = 0;
    Eigen::Vector2d pixel;  ///< pixel centres at .5
  };
  int columns = 0, rows = 0;  ///< of inner corners
  std::vector<Corner> corners;
  /// the square above and to the left of corner (0, 0) is dark
  bool first_dark = false;
  bool empty() const { return corners.empty(); }
  bool whole() const { return static_cast<int>(corners.size()) == columns * rows; }
};

/// The largest checkerboard of the picture: corners where four sectors alternate between dark and
/// bright, joined to a grid from neighbour to neighbour. Corners that a hand or the picture's edge
/// hides are missing. Works for squares of 8 pixels and more.
/// @param image  RGB or grey
/// @return empty where fewer than 3 x 3 corners hang together
/// Source: ring test after Bennett & Lasenby, "ChESS - quick and robust detection of chess-board
/// features", CVIU 2014; growing a grid as in Geiger et al., ICRA 2012; subpixel places by OpenCV.
CheckerGrid FindCheckerboard(const Image8& image);

/// The same, whatever is inside of the squares, such as markers; the corners are not refined.
/// @param enlarged  how much larger the picture is made first, >= 1: small squares need it
CheckerGrid FindCornerGrid(const Image8& grey, double enlarged);

}  // namespace keypose::capture
