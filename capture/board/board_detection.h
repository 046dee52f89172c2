// Finds the calibration board in a photograph.
#pragma once

#include <vector>

#include "core/calibration_board.h"
#include "core/image.h"

namespace keypose::capture {

/// Inner chessboard corners of the board, each named by its id, to about a tenth of a pixel.
///
/// Markers name places on the board; a homography through their corners, bent by what the nearest
/// of them miss it by (lenses distort), foretells every chessboard corner. The print round it, four
/// half squares with their markers, is then drawn as this photograph should show it and shifted
/// until it fits (Gauss-Newton over shift, brightness and contrast). A corner that the figure hides
/// fits nowhere and is left out.
/// @param image  RGB or grey
/// @return corners by id; none when fewer than two markers are seen
/// Source: Garrido-Jurado et al., "Automatic generation and detection of highly reliable fiducial
/// markers under occlusion", Pattern Recognition 2014 (markers, as in OpenCV); Lucas & Kanade,
/// IJCAI 1981 (the fit). Departs from OpenCV: its interpolation comes out half a pixel off in 4.6,
/// and its refinement by gradients errs by up to 0.9 px where low views press the paper between
/// square and marker to two pixels.
std::vector<BoardCorner> FindBoard(const Image8& image, const BoardLayout& board);

/// What is known of a photograph from the board that it shows.
struct BoardOdds {
  Image8 on_board;  ///< 255 where the board's plane shows the board or its white rim, hidden or not
  ImageF odds;      ///< there: log odds that something stands in front of it, within +-limit
};

/// Compares the board as it should look with what the photograph shows. Shadows are taken for
/// shadows: light may vary smoothly, and by a factor; what is printed may not.
/// @param image    RGB, the photograph shrunk
/// @param corners  of the board in the photograph at full size; fewer than 8 give an empty answer
/// @param factor   size of `image` over that of the photograph
BoardOdds OddsOfBoard(const Image8& image, const std::vector<BoardCorner>& corners, double factor,
                      const BoardLayout& board, double limit);

}  // namespace keypose::capture
