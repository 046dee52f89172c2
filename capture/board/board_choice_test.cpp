// Boards as people have them: what pictures show and what was said become one board, with corners
// where they were drawn.
#include "capture/board/board_choice.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "capture/board/board_detection.h"
#include "capture/board/board_survey.h"
#include "capture/board/testing/seen_board.h"
#include "core/pictures/fit_view.h"
#include "core/values/errors.h"

namespace keypose::capture::board_choice_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;

/// A camera that looks at the board's middle, turned about its axis.
Seeing Looking(const Vector3d& eye, double roll_deg) {
  Seeing seeing;
  seeing.view.camera = {1280, 960, 1250, 1250, 648, 474, 0, 0, 0, 0};
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_deg * M_PI / 180, Vector3d::UnitZ()));
  seeing.view.camera_from_world = Compose({roll, Vector3d::Zero()}, LookAt(eye, {0.02, -0.01, 0}));
  seeing.noise = 1;
  return seeing;
}

/// One upright, one that is turned by more than a quarter.
std::vector<Seeing> Turned() {
  return {Looking({-0.5, -0.4, 0.8}, 4), Looking({0.2, 0.6, 0.9}, 112)};
}

BoardPattern BoardOf(const std::string& text) { return PatternOf(ParseBoard(text), 0.05); }

BoardPattern ShownIn(const std::vector<Image8>& pictures) {
  BoardWish wish;
  wish.square_m = 0.05;
  wish.own_completed = false;
  BoardSurvey survey(wish);
  for (const Image8& picture : pictures) survey.Add(picture);
  EXPECT_TRUE(survey.Pattern().has_value()) << survey.Seen();
  return survey.Pattern().value_or(BoardPattern());
}

std::vector<Image8> PicturesOf(const BoardPattern& truth, const std::vector<Seeing>& views) {
  std::vector<Image8> pictures;
  for (const Seeing& seeing : views) pictures.push_back(Photograph(truth, seeing));
  return pictures;
}

/// Distances of found corners from where the drawn board has them.
struct Misses {
  int corners = 0;
  double rms_px = 0, worst_px = 0;
};

Misses MissesOf(const BoardPattern& truth, const BoardPattern& found,
                const std::vector<Seeing>& views, const std::vector<Image8>& pictures) {
  Misses misses;
  for (std::size_t i = 0; i < views.size(); ++i)
    for (const BoardCorner& corner : FindBoard(pictures[i], found, true)) {
      const Vector3d drawn = truth.layout.Corner(corner.id);
      EXPECT_LT((found.layout.Corner(corner.id) - drawn).norm(), 1e-12) << corner.id;
      const double miss = (corner.pixel - views[i].view.Project(drawn)).norm();
      misses.rms_px += miss * miss;
      misses.worst_px = std::max(misses.worst_px, miss);
      ++misses.corners;
    }
  misses.rms_px = std::sqrt(misses.rms_px / std::max(1, misses.corners));
  return misses;
}

class OtherBoards : public ::testing::TestWithParam<const char*> {};

TEST_P(OtherBoards, AreFoundByThemselvesWithTheirCornersWhereTheyWereDrawn) {
  const BoardPattern truth = BoardOf(GetParam());
  const std::vector<Seeing> views = Turned();
  const std::vector<Image8> pictures = PicturesOf(truth, views);
  BoardPattern found = SeenAsSaid(ShownIn(pictures), {}, 0.05);
  EXPECT_EQ(found.Text(), GetParam());
  const double share = MarkerShareIn(pictures[0], found);
  EXPECT_NEAR(share, truth.layout.marker_m / truth.layout.square_m, 0.01);
  found.layout.marker_m = share * found.layout.square_m;
  const Misses misses = MissesOf(truth, found, views, pictures);
  EXPECT_GE(misses.corners, 0.95 * 2 * truth.layout.CornerCount());
  EXPECT_LT(misses.rms_px, 0.03);
  EXPECT_LT(misses.worst_px, 0.1);
}

INSTANTIATE_TEST_SUITE_P(
    AnyPrint, OtherBoards,
    ::testing::Values("8x11:50mm:DICT_4X4_50", "11x8:50mm:DICT_5X5_50:legacy",
                      "8x10:50mm:DICT_4X4_50:legacy", "7x5:50mm:DICT_6X6_50:first_white",
                      "6x6:50mm:DICT_6X6_50:legacy", "9x6:50mm:DICT_7X7_50",
                      "6x7:50mm:DICT_ARUCO_ORIGINAL", "7x6:50mm:DICT_APRILTAG_16h5:legacy",
                      "5x7:50mm:DICT_APRILTAG_25h9", "6x6:50mm:DICT_APRILTAG_36h10:legacy",
                      "8x5:50mm:DICT_APRILTAG_36h11", "7x5:50mm:DICT_6X6_50:inverted"));

TEST(SeenAsSaid, WhatWasSaidCompletesWhatIsSeen) {
  const BoardPattern seen = BoardOf("8x10:50mm:DICT_4X4_50");
  const BoardPattern board = SeenAsSaid(seen, ParseBoard("8x11:22/16mm:DICT_4X4_100"), 0.05);
  EXPECT_EQ(board.Text(), "8x11:22mm:DICT_4X4_100") << "its last row is out of sight";
  EXPECT_DOUBLE_EQ(board.layout.marker_m, 0.016);
  EXPECT_EQ(SeenAsSaid(seen, ParseBoard("10x8:30mm"), 0.05).Text(), "8x10:30mm:DICT_4X4_50")
      << "columns and rows exchanged: the pictures tell";
}

TEST(SeenAsSaid, ALegacyBoardMayBeSaidWithItsSidesExchanged) {
  const BoardPattern even = BoardOf("7x10:50mm:DICT_4X4_50:legacy"),
                     odd = BoardOf("8x11:50mm:DICT_4X4_50:legacy");
  EXPECT_TRUE(even.first_white);
  EXPECT_FALSE(odd.first_white) << "11 rows were never changed";
  EXPECT_EQ(SeenAsSaid(even, ParseBoard("10x7:50mm:legacy"), 0.05).Text(),
            "7x10:50mm:DICT_4X4_50:legacy");
  EXPECT_EQ(SeenAsSaid(odd, ParseBoard("11x8:50mm:legacy"), 0.05).Text(), "8x11:50mm:DICT_4X4_50");
  const BoardPattern black = BoardOf("7x10:50mm:DICT_4X4_50:first_black");
  EXPECT_THROW(SeenAsSaid(black, ParseBoard("10x7:50mm:legacy"), 0.05), InputError);
}

TEST(SeenAsSaid, KeyposesOwnPrintHasMarkersOfTheirExactSize) {
  const BoardPattern truth = BoardOf("11x8:50mm");
  const BoardPattern shown = ShownIn(PicturesOf(truth, Turned()));
  const double seen = shown.layout.marker_m / shown.layout.square_m;
  EXPECT_NE(seen, 0.75);
  EXPECT_NEAR(seen, 0.75, 0.02);
  const BoardPattern board = SeenAsSaid(shown, ParseBoard("11x8"), 0.022);
  EXPECT_EQ(board.Text(), "11x8:22mm:DICT_5X5_50") << "the smallest dictionary with 44 markers";
  EXPECT_TRUE(IsOwnPrint(board, {}));
  EXPECT_DOUBLE_EQ(board.layout.marker_m, 0.75 * 0.022);
  EXPECT_DOUBLE_EQ(SeenAsSaid(shown, ParseBoard("11x8:22/16mm"), 0.05).layout.marker_m, 0.016);
}

TEST(SeenAsSaid, MarkersOfAnotherSizeOrDictionaryKeepTheSizeThatIsSeen) {
  for (const auto& [text, share] : {std::pair{"11x8:50/30mm:DICT_5X5_50", 0.6},
                                    {"11x8:50/36.4mm:DICT_5X5_50", 0.728},
                                    {"11x8:50/37mm:DICT_4X4_50", 0.74},
                                    {"11x8:50/37mm:DICT_5X5_50:legacy", 0.74}}) {
    const BoardPattern seen = BoardOf(text);
    EXPECT_NEAR(SeenAsSaid(seen, ParseBoard("11x8"), 0.022).layout.marker_m, share * 0.022, 1e-12)
        << text;
  }
  const BoardPattern almost = BoardOf("11x8:50/37mm:DICT_5X5_50");
  EXPECT_DOUBLE_EQ(SeenAsSaid(almost, ParseBoard("11x8"), 0.022).layout.marker_m, 0.75 * 0.022);
}

TEST(SeenAsSaid, AnotherBoardIsNamedWithTheTextToGive) {
  const BoardPattern seen = BoardOf("8x10:22mm:DICT_4X4_50:legacy");
  for (const char* said : {"9x10", "8x10:DICT_5X5_100", "8x10:first_black", "8x10:inverted"}) {
    try {
      SeenAsSaid(seen, ParseBoard(said), 0.022);
      ADD_FAILURE() << said;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("a ChArUco board of 8 x 10 squares, DICT_4X4_50, in the "
                                          "layout of OpenCV before 4.6"))
          << said;
      EXPECT_THAT(error.what(), HasSubstr("--board 8x10:22mm:DICT_4X4_50:legacy")) << said;
    }
  }
}

TEST(BoardSurvey, RowsThatOnlySomePicturesShowAreCounted) {
  const std::vector<Seeing> views = {Looking({0, -0.3, 0.9}, 0), Looking({0.2, -0.5, 0.8}, 0)};
  std::vector<Image8> pictures = PicturesOf(BoardOf("10x8:50mm:DICT_4X4_50"), views);
  Image8& first = pictures[0];  // its lower part is out of sight
  std::fill(first.data.begin() + 600 * first.width, first.data.end(), std::uint8_t{110});
  const BoardPattern partly = ShownIn({first});
  EXPECT_LT(partly.layout.rows, 8);
  EXPECT_EQ(partly.layout.columns, 10);
  EXPECT_EQ(ShownIn(pictures).Text(), "10x8:50mm:DICT_4X4_50");
}

TEST(BoardSurvey, AMirroredPrintIsKnownAndOnlyFoundInAMirror) {
  std::vector<Seeing> views = Turned();
  for (Seeing& seeing : views) seeing.mirrored = true;
  const std::vector<Image8> pictures = PicturesOf(BoardOf("7x5:50mm:DICT_6X6_50"), views);
  BoardPattern shown = ShownIn(pictures);
  EXPECT_EQ(shown.Text(), "7x5:50mm:DICT_6X6_50");
  EXPECT_TRUE(shown.mirrored);
  EXPECT_EQ(FindBoard(pictures[0], shown, true).size(), 24u);
  shown.mirrored = false;
  EXPECT_TRUE(FindBoard(pictures[0], shown, true).empty());
}

}  // namespace keypose::capture::board_choice_test
