#include "capture/board/board_pattern.h"

#include <fmt/format.h>

#include <array>
#include <opencv2/aruco.hpp>

#include "core/values/errors.h"

namespace keypose::capture {

int BoardPattern::MarkerCount() const { return MarkersOfBoard(layout, *this); }

std::pair<int, int> BoardPattern::SquareOf(int marker) const {
  // Markers lie in every other square, row by row: two squares compete for each number.
  for (const int square : {2 * marker, 2 * marker + 1}) {
    const int row = square / layout.columns, column = square % layout.columns;
    if (((row + column) % 2 == 0) == first_white) return {column, row};
  }
  throw InputError("capture: the board has no marker " + std::to_string(marker));
}

int BoardPattern::Turns() const {
  if (kind == Kind::kCharuco) return 1;
  const int columns = layout.columns, rows = layout.rows;
  if (columns != rows) return (columns + rows) % 2 == 0 ? 2 : 1;
  return columns % 2 == 1 ? 4 : 2;
}

std::string BoardPattern::Name() const {
  if (kind == Kind::kCheckerboard)
    return fmt::format("a checkerboard of {} x {} inner corners", layout.columns - 1,
                       layout.rows - 1);
  return fmt::format("a ChArUco board of {} x {} squares, {}{}{}", layout.columns, layout.rows,
                     DictionaryName(dictionary),
                     !first_white           ? ""
                     : layout.rows % 2 == 0 ? ", in the layout of OpenCV before 4.6"
                                            : ", with a marker in its first square",
                     inverted ? ", printed inverted" : "");
}

std::vector<std::string> BoardPattern::Problems() const {
  return kind == Kind::kCharuco ? BoardProblems(layout, *this) : layout.Problems();
}

const std::vector<int>& LargestDictionaries() {
  using namespace cv::aruco;
  static const std::vector<int> kLargest{
      DICT_4X4_1000,      DICT_5X5_1000,       DICT_6X6_1000,
      DICT_7X7_1000,      DICT_ARUCO_ORIGINAL, DICT_APRILTAG_16h5,
      DICT_APRILTAG_25h9, DICT_APRILTAG_36h10, DICT_APRILTAG_36h11};
  return kLargest;
}

int SmallestDictionary(int largest, int markers) {
  using namespace cv::aruco;
  if (largest > DICT_7X7_1000) return largest;
  constexpr std::array kSizes{50, 100, 250, 1000};
  const int first = largest / 4 * 4;
  for (int i = 0; i < 4; ++i)
    if (markers <= kSizes[i]) return first + i;
  return largest;
}

std::vector<std::vector<int>> MarkerInk(int dictionary, int marker) {
  const auto words =
      cv::aruco::getPredefinedDictionary(cv::aruco::PREDEFINED_DICTIONARY_NAME(dictionary));
  const cv::Mat bits =
      cv::aruco::Dictionary::getBitsFromByteList(words->bytesList.row(marker), words->markerSize);
  std::vector<std::vector<int>> ink(bits.rows + 2, std::vector<int>(bits.cols + 2, 1));
  for (int r = 0; r < bits.rows; ++r)
    for (int c = 0; c < bits.cols; ++c) ink[r + 1][c + 1] = bits.at<std::uint8_t>(r, c) ? 0 : 1;
  return ink;
}

}  // namespace keypose::capture
