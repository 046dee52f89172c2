#include "capture/shoot/session/shot_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "capture/pictures/cv_image.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::checks_test {

/// A speckled clay figure before a grey wall; `arm_px`: its right arm hangs that much lower.
Image8 Figure(double arm_px = 0, double shift_px = 0, double size = 1) {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar(120, 122, 125));
  std::mt19937 random(7);
  cv::Mat speckles(480, 640, CV_8UC3);
  for (int y = 0; y < speckles.rows; ++y)
    for (int x = 0; x < speckles.cols; ++x) {
      const int value = 150 + static_cast<int>(random() % 105);
      speckles.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<std::uint8_t>(value), static_cast<std::uint8_t>(value * 0.55), 40);
    }
  cv::GaussianBlur(speckles, speckles, {0, 0}, 1.5);
  const auto moved = [&](double dx, double dy) {
    cv::Mat out;
    const cv::Mat warp = (cv::Mat_<double>(2, 3) << 1, 0, dx, 0, 1, dy);
    cv::warpAffine(speckles, out, warp, speckles.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
    return out;
  };
  cv::Mat body(image.size(), CV_8U, cv::Scalar(0)), arm = body.clone();
  cv::ellipse(body, cv::Point2d(320 + shift_px, 260), cv::Size2d(70 * size, 130 * size), 0, 0, 360,
              255, -1);
  cv::ellipse(arm, cv::Point2d(430 + shift_px, 220 + arm_px), {60, 22}, 0, 0, 360, 255, -1);
  moved(shift_px, 0).copyTo(image, body);
  moved(shift_px, arm_px).copyTo(image, arm);
  return ImageOf(image);
}

Image8 Blurred(const Image8& image) {
  cv::Mat out;
  cv::GaussianBlur(MatOf(image), out, {0, 0}, 5);
  return ImageOf(out);
}

PhotographEntry EntryOf(const Image8& image, int index) {
  const Measured measured = MeasurePhotograph(image);
  PhotographEntry entry;
  entry.shot = {0, 1, index};
  entry.width = measured.width, entry.height = measured.height;
  entry.crispness = measured.crispness, entry.sharpness = measured.sharpness;
  entry.exposure = measured.exposure;
  entry.light = measured.light, entry.clipped = measured.clipped;
  entry.mask_fraction = measured.mask_fraction, entry.touches_border = measured.touches_border;
  return entry;
}

/// A ring of good photographs, and one that is not.
SideFile RingWith(const Image8& odd) {
  SideFile side;
  side.plan = {.rings_deg = {12}, .angles = 6};
  const PhotographEntry good = EntryOf(Figure(), 0);
  for (int i = 0; i < 6; ++i) {
    PhotographEntry entry = good;
    entry.shot.index = i;
    side.photographs[entry.shot] = entry;
  }
  side.photographs[{0, 1, 3}] = EntryOf(odd, 3);
  JudgeAll(&side);
  return side;
}

std::vector<std::string> CodesAt(const SideFile& side, int index) {
  std::vector<std::string> codes;
  for (const Finding& finding : side.photographs.at({0, 1, index}).findings) {
    codes.push_back(finding.code);
    EXPECT_FALSE(finding.words.empty());
    EXPECT_FALSE(finding.what_to_do.empty());
  }
  return codes;
}

using Codes = std::vector<std::string>;

TEST(MeasurePhotograph, FindsTheFigure) {
  const Measured measured = MeasurePhotograph(Figure());
  const double area = (M_PI * 70 * 130 + M_PI * 60 * 22 * 0.8) / (640 * 480);
  EXPECT_NEAR(measured.mask_fraction, area, 0.15 * area);
  EXPECT_FALSE(measured.touches_border);
  EXPECT_NEAR(measured.light, std::pow(122 / 255.0, 2.2), 0.02);
}

TEST(JudgeAll, FindsNothingWrongWithAGoodRing) {
  const SideFile side = RingWith(Figure());
  for (int i = 0; i < 6; ++i) EXPECT_EQ(CodesAt(side, i), Codes{}) << i;
}

TEST(JudgeAll, FindsTheBlurredPhotograph) {
  const SideFile side = RingWith(Blurred(Figure()));
  EXPECT_EQ(CodesAt(side, 3), Codes{"blurred"});
  EXPECT_EQ(CodesAt(side, 2), Codes{});
}

TEST(JudgeAll, FindsTheDarkerPhotographAndSaysHowMuch) {
  Image8 dark = Figure();
  for (std::uint8_t& value : dark.data)  // half of the linear light: a stop
    value = static_cast<std::uint8_t>(std::lround(value * std::pow(0.5, 1 / 2.2)));
  const SideFile side = RingWith(dark);
  ASSERT_EQ(CodesAt(side, 3), Codes{"exposure"});
  EXPECT_NE(side.photographs.at({0, 1, 3}).findings[0].words.find("1.0 stops darker"),
            std::string::npos);
}

TEST(JudgeAll, FindsTheEmptySetAndTheCutOffFigure) {
  const Image8 wall(640, 480, 3, 122);
  EXPECT_EQ(CodesAt(RingWith(wall), 3), (Codes{"no-figure"}));
  EXPECT_EQ(CodesAt(RingWith(Figure(0, 0, 1.7)), 3), Codes{"touches-border"});
}

TEST(JudgeAll, FindsAnotherSize) {
  Image8 smaller(320, 240, 3);
  cv::Mat small;
  cv::resize(MatOf(Figure()), small, {320, 240}, 0, 0, cv::INTER_AREA);
  const Codes codes = CodesAt(RingWith(ImageOf(small)), 3);
  EXPECT_EQ(codes.front(), "size");
}

TEST(JudgeAll, NamesMissingAnglesAndTheLargestGap) {
  SideFile side = RingWith(Figure());
  side.photographs.erase({0, 1, 4});
  side.photographs.erase({0, 1, 5});
  side.rings.push_back({0, 1, 0.2, {}, {}});
  JudgeAll(&side);
  EXPECT_EQ(side.rings[0].missing_deg, (std::vector<double>{240, 300}));
  ASSERT_EQ(side.rings[0].findings.size(), 1u);
  EXPECT_NE(side.rings[0].findings[0].words.find("the largest gap is 180"), std::string::npos);
}

TEST(JudgeAll, SaysThatTheFigureMovedOnlyWhenItDid) {
  SideFile side = RingWith(Figure());
  side.rings.push_back({0, 1, 0.9, {}, {}});
  JudgeAll(&side);
  EXPECT_TRUE(side.rings[0].findings.empty());
  side.rings[0].moved_px = 6;
  JudgeAll(&side);
  ASSERT_EQ(side.rings[0].findings.size(), 1u);
  EXPECT_EQ(side.rings[0].findings[0].code, "moved");
}

TEST(MovedBetween, IsNothingForTheSamePhotograph) {
  EXPECT_LT(MovedBetween(Figure(), Figure()), 0.05);
}

TEST(MovedBetween, MeasuresAShiftOfTheWholeFigure) {
  for (const double shift_px : {1.5, 4.0, 9.0})
    EXPECT_NEAR(MovedBetween(Figure(), Figure(0, shift_px)), shift_px, 0.3) << shift_px;
}

TEST(MovedBetween, NoticesOneSunkArm) { EXPECT_NEAR(MovedBetween(Figure(), Figure(5)), 5, 0.5); }

TEST(MovedBetween, OfDifferentSizesThrows) {
  EXPECT_THROW(MovedBetween(Figure(), Image8(10, 10, 3)), InputError);
}

}  // namespace keypose::capture::shoot::checks_test
