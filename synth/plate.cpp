#include "synth/plate.h"

#include <algorithm>
#include <cmath>
#include <opencv2/aruco/charuco.hpp>

#include "core/errors.h"

namespace keypose::synth {

Plate MakePlate(const PlateOptions& options) {
  constexpr int kPixelsPerSquare = 80;
  if (options.squares_x < 3 || options.squares_y < 3 || options.squares_x * options.squares_y / 2 > 100)
    throw UsageError("synth: a plate has 3 x 3 squares or more, and at most 100 markers");
  if (!(options.marker_m > 0 && options.marker_m < options.square_m))
    throw UsageError("synth: the plate's markers must be smaller than its squares");
  const cv::Ptr<cv::aruco::Dictionary> dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  const cv::Ptr<cv::aruco::CharucoBoard> board = cv::aruco::CharucoBoard::create(
      options.squares_x, options.squares_y, static_cast<float>(options.square_m), static_cast<float>(options.marker_m), dictionary);
  cv::Mat drawing;
  board->draw({options.squares_x * kPixelsPerSquare, options.squares_y * kPixelsPerSquare}, drawing, 0, 1);

  Plate plate;
  plate.border_m = options.square_m / 2;
  constexpr int kBorder = kPixelsPerSquare / 2;
  plate.picture = Image8(drawing.cols + 2 * kBorder, drawing.rows + 2 * kBorder, 1, 255);
  for (int y = 0; y < drawing.rows; ++y) std::copy_n(drawing.ptr(y), drawing.cols, plate.picture.at(kBorder, y + kBorder));
  const double board_width = options.squares_x * options.square_m, board_height = options.squares_y * options.square_m;
  plate.width_m = board_width + 2 * plate.border_m;
  plate.height_m = board_height + 2 * plate.border_m;
  plate.corners.resize(static_cast<Eigen::Index>(board->chessboardCorners.size()), 3);
  for (Eigen::Index i = 0; i < plate.corners.rows(); ++i) {
    // OpenCV counts the board's y downwards in its drawing.
    const cv::Point3f& p = board->chessboardCorners[static_cast<std::size_t>(i)];
    plate.corners.row(i) << p.x - board_width / 2, board_height / 2 - p.y, 0;
  }
  return plate;
}

}  // namespace keypose::synth
