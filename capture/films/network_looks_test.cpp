#include "capture/films/network_looks.h"

#include <gtest/gtest.h>

#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture::network_looks_test {

constexpr int kSide = 60;

/// A dark actor beside a dark chair: 20 x 40 each.
Image8 PaintedPair(std::uint8_t actor_grey) {
  cv::Mat rgb(kSide, kSide, CV_8UC3, cv::Scalar::all(200));
  rgb(cv::Rect(10, 10, 20, 40)) = cv::Scalar::all(actor_grey);
  rgb(cv::Rect(30, 10, 20, 40)) = cv::Scalar::all(30);
  return ImageOf(rgb);
}

Image8 PaintedMask(const cv::Rect& area) {
  cv::Mat mask = cv::Mat::zeros(kSide, kSide, CV_8U);
  mask(area) = 255;
  return ImageOf(mask);
}

/// Tells the actor from the chair by the places that they have in the square it is shown.
Image8 OnlyTheLeft(const Image8& rgb) {
  cv::Mat seen = cv::Mat::zeros(rgb.height, rgb.width, CV_8U);
  const int left = rgb.width - rgb.width * 5 / 6;
  seen(cv::Rect(left, 0, rgb.width / 2 - left, rgb.height)) = 255;
  return ImageOf(seen);
}

TEST(NetworkLooks, TellWhatIsNotTheActorInItsMask) {
  NetworkLooks looks;
  const Image8 picture = PaintedPair(30);
  cv::Mat salience = cv::Mat::zeros(kSide, kSide, CV_8U);
  salience(cv::Rect(10, 10, 20, 40)) = 255;
  salience(cv::Rect(30, 10, 10, 40)) = 255;  // alike enough
  const AskNetwork network = [&](const Image8& rgb) {
    return ImageOf(salience(
        cv::Rect((kSide - rgb.width) / 2, (kSide - rgb.height) / 2, rgb.width, rgb.height)));
  };
  ASSERT_TRUE(looks.Add(4, picture, picture, PaintedMask({10, 10, 40, 40}), network));
  const ImageF odds = looks.Odds(4, picture, 6);
  EXPECT_GT(*odds.at(20, 30), 1);
  EXPECT_LT(*odds.at(46, 30), -1);
}

TEST(NetworkLooks, AnOpinionOnSomethingElseIsForgotten) {
  NetworkLooks looks;
  const Image8 picture = PaintedPair(30);
  EXPECT_FALSE(looks.Add(4, picture, picture, PaintedMask({10, 10, 40, 40}), OnlyTheLeft));
  EXPECT_FALSE(looks.Add(4, picture, picture, PaintedMask({0, 0, 0, 0}), OnlyTheLeft));
  EXPECT_TRUE(looks.empty());
}

TEST(NetworkLooks, AnOpinionHoldsWhereColoursStayAndFades) {
  NetworkLooks looks;
  const Image8 picture = PaintedPair(30), changed = PaintedPair(90);
  const AskNetwork all = [](const Image8& rgb) { return Image8(rgb.width, rgb.height, 1, 255); };
  ASSERT_TRUE(looks.Add(4, picture, picture, PaintedMask({5, 5, 50, 50}), all));
  const float then = *looks.Odds(4, picture, 6).at(20, 30),
              later = *looks.Odds(8, picture, 6).at(20, 30),
              latest = *looks.Odds(40, picture, 6).at(20, 30);
  EXPECT_GT(then, later);
  EXPECT_GT(later, latest);
  EXPECT_GT(latest, 0);
  EXPECT_EQ(*looks.Odds(8, changed, 6).at(20, 30), 0);
  EXPECT_EQ(*looks.Odds(8, changed, 6).at(40, 30), later);
}

}  // namespace keypose::capture::network_looks_test
