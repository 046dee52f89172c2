#include "capture/board/board_print.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/board/board_detection.h"
#include "core/values/calibration_board.h"
#include "core/values/camera.h"
#include "core/values/errors.h"

namespace keypose::capture::board_print_test {

using ::testing::HasSubstr;

cv::Mat View(const Image8& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data())};
}

TEST(BoardPrint, PageIsTheBoardThatOpenCvDraws) {
  const BoardLayout board;
  const Page page = PageNamed("A4");
  constexpr double kScale = 8;  // px/mm
  const Image8 picture = BoardPicture(board, page, kScale);
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  const auto cv_board =
      cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.square_m),
                                      static_cast<float>(board.marker_m), dictionary);
  const int square = static_cast<int>(1000 * board.square_m * kScale);
  cv::Mat drawing;
  cv_board->draw({board.columns * square, board.rows * square}, drawing, 0, 1);
  const cv::Rect middle((picture.width - drawing.cols) / 2, (picture.height - drawing.rows) / 2,
                        drawing.cols, drawing.rows);
  cv::Mat difference = cv::abs(View(picture)(middle) - drawing) > 127;
  // The cross in the middle is the only part that OpenCV's board lacks.
  difference(cv::Rect(drawing.cols / 2 - 40, drawing.rows / 2 - 40, 80, 80)).setTo(0);
  // OpenCV rounds markers' borders to whole pixels, so differences are at most that thick.
  cv::erode(difference, difference, cv::Mat::ones(5, 5, CV_8U));
  EXPECT_EQ(cv::countNonZero(difference), 0);
  EXPECT_GT(cv::countNonZero(drawing < 127), drawing.total() / 3);
}

TEST(BoardPrint, CornersLieInExactMillimetres) {
  const BoardLayout board{7, 5, 0.020, 0.015};
  const Page page = PageNamed("letter");
  constexpr double kScale = 6;
  const Image8 picture = BoardPicture(board, page, kScale);
  cv::GaussianBlur(View(picture), View(picture), {0, 0}, 0.7);  // as sharp as a lens is
  const auto corners = FindBoard(picture, board);
  ASSERT_EQ(corners.size(), 24u);
  for (const BoardCorner& corner : corners) {
    const Eigen::Vector3d at = 1000 * board.Corner(corner.id);
    const Eigen::Vector2d expected(kScale * (page.width_mm / 2 + at.x()),
                                   kScale * (page.height_mm / 2 - at.y()));
    EXPECT_LT((corner.pixel - expected).norm(), 0.05) << corner.id;
  }
}

TEST(BoardPrint, PdfHasOnePageOfThePapersSizeAndTheSameBytesEachTime) {
  const std::string pdf = BoardPdf({}, PageNamed("A4"));
  EXPECT_EQ(pdf.substr(0, 5), "%PDF-");
  EXPECT_THAT(pdf, HasSubstr("/Count 1"));
  EXPECT_THAT(pdf, HasSubstr("841.88"));  // 297 mm in points
  EXPECT_THAT(pdf, HasSubstr("595.27"));
  EXPECT_EQ(pdf, BoardPdf({}, PageNamed("A4")));
}

TEST(BoardPrint, BoardThatDoesNotFitIsAUsageErrorThatSaysWhatFits) {
  try {
    BoardPdf({11, 8, 0.040, 0.030}, PageNamed("A4"));
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--board_square_mm may be 24.4 at most"));
  }
  try {
    BoardPdf({20, 20, 0.005, 0.004}, PageNamed("A4"));
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_THAT(error.what(), HasSubstr("more markers than the 100 of DICT_5X5_100"));
  }
  EXPECT_THROW(PageNamed("A7"), UsageError);
}

}  // namespace keypose::capture::board_print_test
