#include "synth/photographs/board_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/aruco/charuco.hpp>

#include "core/values/errors.h"

namespace keypose::synth {

BoardPicture MakeBoardPicture(const BoardOptions& options) {
  constexpr int kPixelsPerSquare = 80;
  if (options.squares_x < 3 || options.squares_y < 3 ||
      options.squares_x * options.squares_y / 2 > 100)
    throw UsageError(
        "synth: a calibration board needs at least 3 x 3 squares, and at most 100 markers");
  if (!(options.marker_m > 0 && options.marker_m < options.square_m))
    throw UsageError("synth: the board's markers must be smaller than its squares");
  const cv::Ptr<cv::aruco::Dictionary> dictionary =
      cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  const cv::Ptr<cv::aruco::CharucoBoard> layout = cv::aruco::CharucoBoard::create(
      options.squares_x, options.squares_y, static_cast<float>(options.square_m),
      static_cast<float>(options.marker_m), dictionary);
  cv::Mat drawing;
  layout->draw({options.squares_x * kPixelsPerSquare, options.squares_y * kPixelsPerSquare},
               drawing, 0, 1);

  BoardPicture board;
  board.border_m = options.square_m / 2;
  constexpr int kBorder = kPixelsPerSquare / 2;
  board.picture = Image8(drawing.cols + 2 * kBorder, drawing.rows + 2 * kBorder, 1, 255);
  for (int y = 0; y < drawing.rows; ++y)
    std::copy_n(drawing.ptr(y), drawing.cols, board.picture.at(kBorder, y + kBorder));
  const double board_width = options.squares_x * options.square_m,
               board_height = options.squares_y * options.square_m;
  board.width_m = board_width + 2 * board.border_m;
  board.height_m = board_height + 2 * board.border_m;
  board.corners.resize(std::ssize(layout->chessboardCorners), 3);
  for (Eigen::Index i = 0; i < board.corners.rows(); ++i) {
    // In OpenCV's drawing, the board's y points downwards.
    const cv::Point3f& p = layout->chessboardCorners[i];
    board.corners.row(i) << p.x - board_width / 2, board_height / 2 - p.y, 0;
  }
  return board;
}

}  // namespace keypose::synth
