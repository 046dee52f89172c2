#include "synth/photographs/board_picture.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "core/values/errors.h"

namespace keypose::synth {

namespace {

constexpr int kPixelsPerSquare = 80;

/// The layout of OpenCV 4.6 and later: its own drawing.
cv::Mat DrawnByOpenCv(const BoardOptions& options,
                      const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  const auto board = cv::aruco::CharucoBoard::create(
      options.squares_x, options.squares_y, static_cast<float>(options.square_m),
      static_cast<float>(options.marker_m), dictionary);
  cv::Mat drawing;
  board->draw({options.squares_x * kPixelsPerSquare, options.squares_y * kPixelsPerSquare}, drawing,
              0, 1);
  return drawing;
}

/// A white square with a marker at the top left.
cv::Mat DrawnFromWhite(const BoardOptions& options,
                       const cv::Ptr<cv::aruco::Dictionary>& dictionary) {
  constexpr int kPx = 2 * kPixelsPerSquare;  // so that markers lie in the middle
  cv::Mat drawing(options.squares_y * kPx, options.squares_x * kPx, CV_8UC1, cv::Scalar(255));
  const int side = 2 * static_cast<int>(std::lround(kPx * options.marker_m / options.square_m / 2));
  int marker = 0;
  for (int row = 0; row < options.squares_y; ++row)
    for (int column = 0; column < options.squares_x; ++column) {
      cv::Mat square = drawing(cv::Rect(column * kPx, row * kPx, kPx, kPx));
      if ((row + column) % 2 == 1) {
        square.setTo(0);
        continue;
      }
      cv::Mat ink;
      cv::aruco::drawMarker(dictionary, marker++, side, ink, 1);
      ink.copyTo(square(cv::Rect((kPx - side) / 2, (kPx - side) / 2, side, side)));
    }
  cv::resize(drawing, drawing, {}, 0.5, 0.5, cv::INTER_AREA);
  return drawing;
}

}  // namespace

void BoardOptions::Say(const std::string& text) {
  const SaidBoard said = ParseBoard(text);
  squares_x = said.columns;
  squares_y = said.rows;
  const double share = marker_m / square_m;
  if (said.square_m > 0) square_m = said.square_m;
  marker_m = said.marker_m > 0 ? said.marker_m : share * square_m;
  print.dictionary = said.dictionary.value_or(print.dictionary);
  print.first_white = said.FirstWhite(said.rows).value_or(print.first_white);
  print.inverted = said.inverted;
  charuco = true;
}

BoardPicture MakeBoardPicture(const BoardOptions& options) {
  if (const auto problems = BoardProblems(options.Layout(), options.print); !problems.empty())
    throw UsageError("synth: " + problems.front());
  const cv::Ptr<cv::aruco::Dictionary> dictionary = cv::aruco::getPredefinedDictionary(
      cv::aruco::PREDEFINED_DICTIONARY_NAME(options.print.dictionary));
  const cv::Mat drawing = options.print.first_white ? DrawnFromWhite(options, dictionary)
                                                    : DrawnByOpenCv(options, dictionary);

  BoardPicture board;
  board.border_m = options.square_m / 2;
  constexpr int kBorder = kPixelsPerSquare / 2;
  board.picture = Image8(drawing.cols + 2 * kBorder, drawing.rows + 2 * kBorder, 1, 255);
  for (int y = 0; y < drawing.rows; ++y)
    std::copy_n(drawing.ptr(y), drawing.cols, board.picture.at(kBorder, y + kBorder));
  if (options.print.inverted)
    for (std::uint8_t& level : board.picture.data) level = static_cast<std::uint8_t>(255 - level);
  const double board_width = options.squares_x * options.square_m,
               board_height = options.squares_y * options.square_m;
  board.width_m = board_width + 2 * board.border_m;
  board.height_m = board_height + 2 * board.border_m;
  const BoardLayout layout = options.Layout();
  board.corners.resize(layout.CornerCount(), 3);
  for (int id = 0; id < layout.CornerCount(); ++id)
    board.corners.row(id) = layout.Corner(id).transpose();
  return board;
}

}  // namespace keypose::synth
