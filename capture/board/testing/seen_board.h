// Boards as cameras see them, rendered for tests: drawn here and by OpenCV's markers, not by the
// code under test.
#pragma once

#include "capture/board/board_pattern.h"
#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::capture {

struct Seeing {
  View view;  ///< without distortion; the board is the plane z = 0, its middle the origin
  double blur_px = 0.6;
  double noise = 2;       ///< grey levels
  bool mirrored = false;  ///< the picture, left and right exchanged
};

/// The board on a grey ground, with 4 x 4 rays a pixel.
/// @param seed  of the noise
Image8 Photograph(const BoardPattern& pattern, const Seeing& seeing, int seed = 7);

/// A ChArUco board of squares of 50 mm.
/// @param share  of a square that its marker takes
BoardPattern Charuco(int columns, int rows, int dictionary, double share = 0.75);

/// A checkerboard of squares of 50 mm.
BoardPattern Checkers(int columns, int rows);

}  // namespace keypose::capture
