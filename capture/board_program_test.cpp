// The program keypose-capture on photographs of boards that other programs printed.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "capture/board/board_choice.h"
#include "capture/board/testing/seen_board.h"
#include "capture/testing/capture_program.h"
#include "core/io/pictures/image_io.h"
#include "core/io/pictures/image_set.h"
#include "core/pictures/fit_view.h"

namespace keypose::capture::board_program_test {

using ::testing::HasSubstr;
using ::testing::Not;

class BoardProgram : public CaptureProgram {
 protected:
  static constexpr int kViews = 4;

  static Seeing SeeingOf(int view) {
    Seeing seeing;
    seeing.view.camera = {960, 720, 950, 950, 484, 356, 0, 0, 0, 0};
    const double angle = 0.6 + 1.6 * view;
    seeing.view.camera_from_world =
        LookAt({0.6 * std::cos(angle), 0.6 * std::sin(angle), 0.8}, {0.01, 0, 0});
    seeing.noise = 1;
    return seeing;
  }
  /// Photographs of a board all round; its squares are of 50 mm.
  void Shoot(const std::string& board, bool mirrored = false) {
    truth_ = PatternOf(ParseBoard(board), 0.05);
    std::filesystem::remove_all(photos);
    std::filesystem::create_directories(photos);
    for (int view = 0; view < kViews; ++view) {
      Seeing seeing = SeeingOf(view);
      seeing.mirrored = mirrored;
      WriteImage(photos / ("p" + std::to_string(view) + ".png"), Photograph(truth_, seeing));
    }
  }
  Outcome Capture(const std::string& options = "") {
    return Run("--min_images 2 --min_sharpness 0 --max_bad_share 1 " + options);
  }
  /// Root mean square distance of the corners in capture.json from where they were drawn.
  double MissesPx() const {
    const ImageSet set = ReadImageSet(images);
    double sum = 0;
    int count = 0;
    for (int view = 0; view < kViews; ++view)
      for (const BoardCorner& corner : set.images[view].board_corners) {
        const Eigen::Vector3d at = truth_.layout.Corner(corner.id);
        sum += (corner.pixel - SeeingOf(view).view.Project(at)).squaredNorm();
        ++count;
      }
    EXPECT_GE(count, 0.9 * kViews * truth_.layout.CornerCount());
    return std::sqrt(sum / std::max(1, count));
  }
  BoardPattern truth_;
};

TEST_F(BoardProgram, AnotherBoardIsUsedAndTheSideOfItsSquaresIsAskedFor) {
  Shoot("8x6:50mm:DICT_4X4_50:legacy");
  const Outcome outcome = Capture();
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output,
              HasSubstr("8 x 6 squares, DICT_4X4_50, in the layout of OpenCV before "
                        "4.6"));
  EXPECT_THAT(outcome.output, HasSubstr("--board 8x6:22mm:DICT_4X4_50:legacy"));
  const ImageSet set = ReadImageSet(images);
  ASSERT_TRUE(set.board.has_value());
  EXPECT_EQ(DictionaryName(set.board_print.dictionary), "DICT_4X4_50");
  EXPECT_TRUE(set.board_print.first_white);
  EXPECT_DOUBLE_EQ(set.board->square_m, 0.022);
  EXPECT_NEAR(set.board->marker_m, 0.75 * 0.022, 0.0002);
  EXPECT_LT(MissesPx(), 0.05);
}

TEST_F(BoardProgram, ABoardThatIsSaidIsUsedAsItIsSaid) {
  Shoot("7x5:50mm:DICT_APRILTAG_36h11");
  const Outcome outcome = Capture("--board 7x5:50mm:DICT_APRILTAG_36h11");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, Not(HasSubstr("one factor")));
  const ImageSet set = ReadImageSet(images);
  ASSERT_TRUE(set.board.has_value());
  EXPECT_DOUBLE_EQ(set.board->square_m, 0.05);
  EXPECT_LT((set.board->Corner(0) - truth_.layout.Corner(0)).norm(), 1e-12);
  EXPECT_LT(MissesPx(), 0.05);
}

TEST_F(BoardProgram, KeyposesOwnPrintMayBeSaidAndKeepsItsExactMarkers) {
  Shoot("11x8:50mm");
  const Outcome outcome = Capture("--board 11x8:50mm");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  const ImageSet set = ReadImageSet(images);
  ASSERT_TRUE(set.board.has_value());
  EXPECT_DOUBLE_EQ(set.board->square_m, 0.05);
  EXPECT_DOUBLE_EQ(set.board->marker_m, 0.0375);
  EXPECT_LT(MissesPx(), 0.05);
}

TEST_F(BoardProgram, TheWrongBoardIsRefusedWithTheRightOptionToType) {
  Shoot("8x6:50mm:DICT_4X4_50:legacy");
  const Outcome outcome = Capture("--board 8x6:50mm:DICT_6X6_50");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.output, HasSubstr("give --board 8x6:50mm:DICT_4X4_50:legacy"));
  EXPECT_EQ(Capture("--board 8x6:50mm:DICT_4X4").code, 2);
  EXPECT_EQ(Capture("--board false").code, 0);
  EXPECT_FALSE(ReadImageSet(images).board.has_value());
}

TEST_F(BoardProgram, AMirroredPrintIsNamedAndNotUsed) {
  Shoot("7x5:50mm:DICT_5X5_100", true);
  const Outcome outcome = Capture();
  EXPECT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(outcome.output, HasSubstr("the print is mirrored: print it anew"));
  EXPECT_FALSE(ReadImageSet(images).board.has_value());
}

}  // namespace keypose::capture::board_program_test
