#include "synth/photographs/board_picture.h"

#include <gtest/gtest.h>
#include <opencv2/aruco/charuco.hpp>
#include <opencv2/imgproc.hpp>

#include "core/numbers/statistics.h"
#include "synth/photographs/photographer.h"
#include "synth/photographs/testing/small_photographs.h"

namespace keypose::synth::board_picture_test {

using Eigen::Vector2d;

TEST(Photographer, OpenCvFindsTheBoardsCornersWhereTheTruthSays) {
  PhotographerOptions options = Small(1);
  options.elevations_deg = {50};
  options.width = 1000, options.height = 750;
  options.fill = 0.5;
  options.board.charuco = true;
  const SyntheticView photograph =
      Photographer(Creature(), Creature().PoseNamed("rest"), options).Take(0);
  const BoardPicture board = MakeBoardPicture(options.board);
  cv::Mat grey(options.height, options.width, CV_8UC1);
  for (int y = 0; y < options.height; ++y)
    for (int x = 0; x < options.width; ++x)
      grey.at<std::uint8_t>(y, x) = photograph.image.at(x, y)[1];
  const auto dictionary = cv::aruco::getPredefinedDictionary(cv::aruco::DICT_5X5_100);
  const auto cv_board = cv::aruco::CharucoBoard::create(
      options.board.squares_x, options.board.squares_y, static_cast<float>(options.board.square_m),
      static_cast<float>(options.board.marker_m), dictionary);
  std::vector<std::vector<cv::Point2f>> markers;
  std::vector<int> ids, corner_ids;
  std::vector<cv::Point2f> corners;
  cv::aruco::detectMarkers(grey, dictionary, markers, ids);
  ASSERT_GE(ids.size(), 10u);
  cv::aruco::interpolateCornersCharuco(markers, ids, grey, cv_board, corners, corner_ids);
  ASSERT_GE(corners.size(), 12u);
  // OpenCV 4.6 returns these corners half a pixel off its own convention, so they are refined
  // again: its pixel centres are at whole numbers.
  cv::cornerSubPix(grey, corners, {4, 4}, {-1, -1},
                   cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-5));
  std::vector<double> errors;
  for (std::size_t i = 0; i < corners.size(); ++i)
    errors.push_back((Vector2d(corners[i].x + 0.5, corners[i].y + 0.5) -
                      photograph.view.Project(board.corners.row(corner_ids[i])))
                         .norm());
  EXPECT_LT(UpperMedian(errors), 0.2);
}

TEST(BoardPicture, PrintsOfOtherProgramsHaveTheirFirstMarkerWhereTheyHaveIt) {
  // text, and the square of marker 0
  for (const auto& [text, column] : {std::pair{"8x10:20mm:DICT_4X4_50", 1},
                                     {"8x10:20mm:DICT_4X4_50:legacy", 0},
                                     {"7x5:20/14mm:DICT_6X6_250:first_white", 0},
                                     {"7x5:20mm:DICT_APRILTAG_36h11:legacy", 1}}) {
    BoardOptions options;
    options.Say(text);
    BoardPicture board = MakeBoardPicture(options);
    const cv::Mat grey(board.picture.height, board.picture.width, CV_8UC1,
                       board.picture.data.data());
    std::vector<std::vector<cv::Point2f>> markers;
    std::vector<int> ids;
    cv::aruco::detectMarkers(grey,
                             cv::aruco::getPredefinedDictionary(
                                 cv::aruco::PREDEFINED_DICTIONARY_NAME(options.print.dictionary)),
                             markers, ids);
    ASSERT_EQ(static_cast<int>(ids.size()), MarkersOfBoard(options.Layout(), options.print))
        << text;
    const auto first = std::find(ids.begin(), ids.end(), 0) - ids.begin();
    const cv::Point2f middle = (markers[first][0] + markers[first][2]) / 2;
    const double square_px = grey.cols * options.square_m / board.width_m;
    EXPECT_NEAR(middle.x / square_px, 0.5 + column + 0.5, 0.02) << text;
    EXPECT_NEAR(middle.y / square_px, 1.0, 0.02) << text;
    const double side = cv::norm(markers[first][1] - markers[first][0]) / square_px;
    EXPECT_NEAR(side, options.marker_m / options.square_m, 0.03) << text;
    EXPECT_EQ(board.corners.rows(), options.Layout().CornerCount());
  }
}

TEST(BoardPicture, InkOfAnInvertedPrintIsWhite) {
  BoardOptions options;
  options.Say("7x5:20mm:DICT_6X6_50");
  const BoardPicture plain = MakeBoardPicture(options);
  options.Say("7x5:20mm:DICT_6X6_50:inverted");
  const BoardPicture inverted = MakeBoardPicture(options);
  for (std::size_t i = 0; i < plain.picture.data.size(); ++i)
    ASSERT_EQ(plain.picture.data[i] + inverted.picture.data[i], 255);
}

}  // namespace keypose::synth::board_picture_test
