#include "capture/board/board_pattern.h"

#include <fmt/format.h>

#include <array>
#include <opencv2/aruco.hpp>

#include "core/values/errors.h"

namespace keypose::capture {
namespace {

constexpr std::array kNames = {"DICT_4X4_50",        "DICT_4X4_100",        "DICT_4X4_250",
                               "DICT_4X4_1000",      "DICT_5X5_50",         "DICT_5X5_100",
                               "DICT_5X5_250",       "DICT_5X5_1000",       "DICT_6X6_50",
                               "DICT_6X6_100",       "DICT_6X6_250",        "DICT_6X6_1000",
                               "DICT_7X7_50",        "DICT_7X7_100",        "DICT_7X7_250",
                               "DICT_7X7_1000",      "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_16h5",
                               "DICT_APRILTAG_25h9", "DICT_APRILTAG_36h10", "DICT_APRILTAG_36h11"};

}  // namespace

int BoardPattern::MarkerCount() const {
  return (layout.columns * layout.rows + (first_white ? 1 : 0)) / 2;
}

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
                     first_white ? ", with a marker in its first square" : "",
                     inverted ? ", printed inverted" : "");
}

std::vector<std::string> BoardPattern::Problems() const {
  if (kind == Kind::kCharuco && dictionary == kOwnDictionary && !first_white)
    return layout.Problems();
  BoardLayout few = layout;  // whose markers every dictionary has
  few.columns = few.rows = 3;
  std::vector<std::string> problems = few.Problems();
  if (layout.columns < 3 || layout.rows < 3)
    problems.push_back(fmt::format("a calibration board has at least 3 x 3 squares, not {} x {}",
                                   layout.columns, layout.rows));
  return problems;
}

std::string DictionaryName(int dictionary) { return kNames.at(dictionary); }

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
