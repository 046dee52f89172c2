// Boards of other programs, rendered as webcams and cameras see them: found by themselves, with
// their corners where they were drawn.
#include "capture/board/board_survey.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/aruco.hpp>

#include "capture/board/testing/seen_board.h"
#include "core/pictures/fit_view.h"

namespace keypose::capture::board_survey_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

/// A camera that looks at the board's middle, turned about its axis.
Seeing From(const Vector3d& eye, double roll_deg, int width = 640, int height = 480,
            double focal_px = 620) {
  Seeing seeing;
  seeing.view.camera = {width, height, focal_px, focal_px, width / 2.0 + 4, height / 2.0 - 3,
                        0,     0,      0,        0};
  const Rigid3 look = LookAt(eye, {0.02, -0.01, 0});
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_deg * M_PI / 180, Vector3d::UnitZ()));
  seeing.view.camera_from_world = Compose({roll, Vector3d::Zero()}, look);
  return seeing;
}

/// A webcam, and one that is turned by a quarter.
std::vector<Seeing> Around() { return {From({-0.5, -0.3, 0.8}, 4), From({0.2, 0.6, 0.9}, 85)}; }

struct Result {
  std::optional<BoardPattern> pattern;
  int least_corners = 1 << 20;
  double rms_px = 0;
};

Result Survey(const BoardPattern& truth, const std::vector<Seeing>& views) {
  BoardWish wish;
  wish.square_m = truth.layout.square_m;
  BoardSurvey survey(wish);
  std::vector<Image8> pictures;
  for (const Seeing& seeing : views) {
    pictures.push_back(Photograph(truth, seeing));
    survey.Add(pictures.back());
  }
  Result result;
  result.pattern = survey.Pattern();
  if (!result.pattern) return result;
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    const FoundBoard found = LookForBoard(pictures[i], *result.pattern);
    result.least_corners = std::min(result.least_corners, static_cast<int>(found.corners.size()));
    for (const BoardCorner& corner : found.corners) {
      Vector2d at = views[i].view.Project(truth.layout.Corner(corner.id));
      if (views[i].mirrored) at.x() = views[i].view.camera.width - at.x();
      sum += (corner.pixel - at).squaredNorm(), ++count;
    }
  }
  result.rms_px = std::sqrt(sum / std::max(1, count));
  return result;
}

void ExpectFound(const BoardPattern& truth, const std::vector<Seeing>& views, double share,
                 double most_px) {
  const Result result = Survey(truth, views);
  ASSERT_TRUE(result.pattern) << truth.Name();
  EXPECT_EQ(result.pattern->Name(), truth.Name());
  EXPECT_EQ(result.pattern->mirrored, views[0].mirrored);
  // from the outlines of small markers
  EXPECT_NEAR(result.pattern->layout.marker_m, truth.layout.marker_m, 0.1 * truth.layout.marker_m);
  EXPECT_GE(result.least_corners, share * truth.layout.CornerCount()) << truth.Name();
  EXPECT_LT(result.rms_px, most_px) << truth.Name();
}

TEST(BoardSurvey, BoardsOfAnySizeAndDictionaryAreFoundInTurnedWebcams) {
  using namespace cv::aruco;
  for (const BoardPattern& truth :
       {Charuco(4, 5, DICT_4X4_50), Charuco(7, 5, DICT_5X5_50, 0.6),
        Charuco(6, 6, DICT_APRILTAG_36h11, 0.8), Charuco(9, 6, DICT_7X7_50, 0.8)})
    ExpectFound(truth, Around(), 0.8, 0.15);
}

TEST(BoardSurvey, LayoutsOfBeforeAndSinceOpenCv46AreToldApart) {
  BoardPattern legacy = Charuco(6, 8, cv::aruco::DICT_4X4_50);
  legacy.first_white = true;
  ExpectFound(legacy, Around(), 0.8, 0.15);
  ExpectFound(Charuco(6, 8, cv::aruco::DICT_4X4_50), Around(), 0.8, 0.15);
}

TEST(BoardSurvey, InvertedAndMirroredPrintsAreFound) {
  BoardPattern inverted = Charuco(4, 5, cv::aruco::DICT_4X4_50);
  inverted.inverted = true;
  ExpectFound(inverted, Around(), 0.8, 0.15);
  std::vector<Seeing> mirrored = Around();
  for (Seeing& seeing : mirrored) seeing.mirrored = true;
  ExpectFound(inverted, mirrored, 0.8, 0.15);
}

TEST(BoardSurvey, SmallMarkersOfWebcamsAreEnough) {
  // squares of 14 to 17 pixels, markers of 11 to 13
  std::vector<Seeing> far = {From({0.3, -0.5, 2.0}, 0), From({-0.4, -0.3, 1.9}, 270)};
  for (Seeing& seeing : far) seeing.noise = 3;
  ExpectFound(Charuco(7, 9, cv::aruco::DICT_4X4_50), far, 0.7, 0.25);
}

TEST(BoardSurvey, CheckerboardsOfAnySizeAreFound) {
  for (const BoardPattern& truth : {Checkers(8, 5), Checkers(10, 7)}) {
    const Result result = Survey(truth, Around());
    ASSERT_TRUE(result.pattern);
    EXPECT_EQ(result.pattern->Name(), truth.Name());
    EXPECT_GE(result.least_corners, 0.95 * truth.layout.CornerCount());
    EXPECT_LT(result.rms_px, 0.1) << truth.Name();
  }
}

TEST(BoardSurvey, ABoardThatCannotBeReadIsNamedAsFarAsItIs) {
  BoardSurvey nothing({});
  nothing.Add(Image8(640, 480, 1, 120));
  EXPECT_FALSE(nothing.Pattern());
  EXPECT_EQ(nothing.Seen(), "");
}

}  // namespace keypose::capture::board_survey_test
