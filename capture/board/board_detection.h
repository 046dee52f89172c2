// Finds the calibration board in a photograph.
#pragma once

#include <vector>

#include "capture/board/board_pattern.h"
#include "core/values/calibration_board.h"
#include "core/values/image.h"

namespace keypose::capture {

/// Inner chessboard corners of the board, each with its id, accurate to about a tenth of a pixel.
///
/// Markers give positions on the board. A homography through their corners, corrected by the
/// residuals of the nearest ones (lens distortion), predicts every chessboard corner. The print
/// around it, four half squares with their markers, is then rendered as this photograph should show
/// it and shifted to the best match (Gauss-Newton over shift, brightness and contrast). A corner
/// that the figure occludes has no match and is left out.
/// @param image  RGB or grey
/// @return corners by id; none when fewer than two markers are found
/// Source: Garrido-Jurado et al., "Automatic generation and detection of highly reliable fiducial
/// markers under occlusion", Pattern Recognition 2014 (markers, as in OpenCV); Lucas & Kanade,
/// IJCAI 1981 (the fit). Departs from OpenCV: its interpolation has an offset of half a pixel in
/// 4.6, and its refinement by gradients has errors of up to 0.9 px where low views reduce the paper
/// between square and marker to two pixels.
std::vector<BoardCorner> FindBoard(const Image8& image, const BoardLayout& board);

/// The same for a board of another program, printed inverted, or seen in a mirror. Its corners are
/// numbered as those of its layout.
/// @param thorough  also markers of a dozen pixels, in pictures of webcams
std::vector<BoardCorner> FindBoard(const Image8& image, const BoardPattern& pattern, bool thorough);

/// Odds of a photograph from the board in it.
struct BoardOdds {
  Image8 on_board;  ///< 255 where the board's plane is the board or its white rim, occluded or not
  ImageF odds;      ///< on the board: log odds that something is in front of it, within +-limit
};

/// Compares the photograph with the expected picture of the board. Shadows are allowed for: the
/// light may vary smoothly and by a factor, the print may not.
/// @param image    RGB, the photograph reduced
/// @param corners  of the board in the photograph at full size; with fewer than 8 the result is
/// empty
/// @param factor   size of `image` over that of the photograph
/// @param board    with markers
BoardOdds OddsOfBoard(const Image8& image, const std::vector<BoardCorner>& corners, double factor,
                      const BoardPattern& board, double limit);

/// How much of a square a marker takes: the share that explains the picture's print best, near that
/// of the pattern.
/// @return 0 where the board is not seen
double MarkerShareIn(const Image8& image, const BoardPattern& pattern);

}  // namespace keypose::capture
