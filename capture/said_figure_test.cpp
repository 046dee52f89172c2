// Clicks and strokes in the photographs that keypose-capture masks: two things before a plain wall.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "capture/testing/capture_program.h"
#include "core/pictures/image_turns.h"

namespace keypose::capture::said_figure_test {

using ::testing::HasSubstr;

constexpr int kWidth = 240, kHeight = 160, kRadius = 24;
constexpr double kAsideX = 200.5, kAsideY = 60.5;

/// The speckled ellipse in the middle, and a disc beside it.
class TwoThings : public CaptureProgram {
 protected:
  void Write(int count) {
    for (int i = 0; i < count; ++i) {
      TestPhoto photo = MakeTestPhoto(i, kWidth, kHeight, TestWall::kLight);
      Image8 aside(kWidth, kHeight, 1, 0);
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
          if (std::hypot(x + 0.5 - kAsideX, y + 0.5 - kAsideY) > kRadius) continue;
          *aside.at(x, y) = 255;
          for (int c = 0; c < 3; ++c)
            photo.image.at(x, y)[c] =
                static_cast<std::uint8_t>(40 + 50 * c + (x * 31 + y * 17 + i) % 23);
        }
      WriteImage(photos / Name(i), photo.image, 95);
      pictures.push_back(photo.image);
      middles.push_back(photo.truth);
      asides.push_back(aside);
    }
  }
  static std::string Name(int i) { return "p" + std::to_string(10 + i) + ".jpg"; }

  /// Intersection over union of a photograph's mask with a truth.
  double Iou(int i, const std::vector<Image8>& truths) const {
    const Image8 mask = ReadImage(images / "masks" / (Name(i) + ".png"), 1);
    const Image8& truth = truths[static_cast<std::size_t>(i)];
    double both = 0, either = 0;
    for (std::size_t p = 0; p < mask.data.size(); ++p)
      both += mask.data[p] && truth.data[p], either += mask.data[p] || truth.data[p];
    return both / either;
  }

  std::vector<Image8> pictures, middles, asides;
};

TEST_F(TwoThings, AClickOnOneLeavesTheOtherOut) {
  Write(8);
  ASSERT_EQ(Run().code, 0);
  for (int i = 0; i < 8; ++i) EXPECT_GT(Iou(i, middles), 0.9) << i;
  const Outcome outcome = Run("--overwrite --figure 'p10.jpg:200,60;p13.jpg:190,60-210,62'");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  for (int i = 0; i < 8; ++i) EXPECT_GT(Iou(i, i == 0 || i == 3 ? asides : middles), 0.9) << i;
  EXPECT_THAT(Report(), HasSubstr("\"figure_strokes\": 2"));
}

TEST_F(TwoThings, WhatIsSaidNotToBeTheFigureStaysWithAWarningWhereNothingElseIsFound) {
  Write(8);  // without a clean plate the set learns that the disc is of the background
  const Outcome outcome = Run("--figure '!p11.jpg:125,83'");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), HasSubstr("in p11.jpg what was said not to be the figure is all"));
  EXPECT_GT(Iou(1, middles), 0.9);
}

TEST_F(TwoThings, WhatIsSaidNotToBeTheFigureIsLeftOutAndTheOtherTaken) {
  Write(8);
  WriteImage(photos / "background.png", MakeTestWall(kWidth, kHeight, TestWall::kLight));
  const Outcome outcome = Run("--figure '!p11.jpg:125,83'");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(Iou(1, asides), 0.9);
  EXPECT_GT(Iou(2, middles), 0.9);
}

TEST_F(TwoThings, AClickInAPortraitThatIsTurnedIsWhereItWasClicked) {
  Write(8);
  const Image8 portrait = QuarterTurned(QuarterTurned(QuarterTurned(pictures[2])));
  WriteImage(photos / Name(2), portrait, 95);
  // Back by a quarter: x of the portrait is y of the landscape, its y counts from the right.
  const Outcome outcome = Run("--figure p12.jpg:60.5," + std::to_string(kWidth - 200.5));
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(Iou(2, asides), 0.9);
}

// The set has learnt that the disc is of the background: the click counts more.
TEST_F(TwoThings, AClickOnWhatTheSetTakesForBackgroundIsSegmentedByItsOwnColours) {
  Write(8);
  WriteImage(photos / "background.png", pictures[7]);
  fs::remove(photos / Name(7));
  const Outcome outcome = Run("--min_images 7 --figure p10.jpg:200,60");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_GT(Iou(0, asides), 0.85);
}

TEST_F(TwoThings, StrokesThatAreNotUsedAreNamed) {
  Write(8);
  fs::create_directories(root / "mine");
  WriteImage(root / "mine/p11.jpg.png", middles[1]);
  const Outcome outcome = Run("--masks " + (root / "mine").string() +
                              " --figure 'elsewhere.jpg:5,5;p11.jpg:200,60;!p12.jpg:30,30'");
  ASSERT_EQ(outcome.code, 0) << outcome.output;
  EXPECT_THAT(Report(), HasSubstr("elsewhere.jpg is not used: there is no such photograph"));
  EXPECT_THAT(Report(), HasSubstr("p11.jpg is not used: it has a mask of your own"));
  EXPECT_GT(Iou(1, middles), 0.99);
  EXPECT_GT(Iou(2, middles), 0.9);  // nothing was there
}

}  // namespace keypose::capture::said_figure_test
