#include "capture/shoot/develop/focus_stack.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>

#include "capture/pictures/cv_image.h"
#include "core/numbers/parallel.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot::focus_stack_test {

/// Speckles of several sizes on a bright form.
Image8 Sharp(int seed) {
  std::mt19937 random(static_cast<unsigned>(seed));
  cv::Mat image(300, 400, CV_8UC3, cv::Scalar(90, 100, 110));
  const auto any = [&](int bound) {
    return static_cast<int>(random() % static_cast<unsigned>(bound));
  };
  cv::ellipse(image, {200, 150}, {120, 90}, 0, 0, 360, cv::Scalar(180, 170, 150), -1);
  for (int i = 0; i < 900; ++i)
    cv::circle(image, {any(400), any(300)}, 1 + any(4), cv::Scalar(any(255), any(255), any(255)),
               -1);
  cv::GaussianBlur(image, image, {0, 0}, 0.7);
  return ImageOf(image);
}

/// In focus only left or right of x = 200, and enlarged a little, as lenses do.
Image8 Focused(const Image8& image, bool left, double scale) {
  cv::Mat blurred, out = MatOf(image).clone(), warped;
  cv::GaussianBlur(out, blurred, {0, 0}, 4);
  const cv::Rect side = left ? cv::Rect(200, 0, 200, 300) : cv::Rect(0, 0, 200, 300);
  blurred(side).copyTo(out(side));
  const cv::Mat grow = cv::getRotationMatrix2D({200, 150}, 0, scale);
  cv::warpAffine(out, warped, grow, out.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  return ImageOf(warped);
}

/// Root mean square difference inside of the border.
double Difference(const Image8& a, const Image8& b) {
  double sum = 0;
  int count = 0;
  for (int y = 20; y < a.height - 20; ++y)
    for (int x = 20; x < a.width - 20; ++x)
      for (int c = 0; c < 3; ++c, ++count) sum += std::pow(a.at(x, y)[c] - b.at(x, y)[c], 2);
  return std::sqrt(sum / count);
}

TEST(MergeFocusStack, IsSharpWhereAnyPhotographIs) {
  const Image8 sharp = Sharp(1);
  const Image8 right = Focused(sharp, false, 1), left = Focused(sharp, true, 1.01);
  const Image8 merged = MergeFocusStack({left, right});
  EXPECT_LT(Difference(merged, sharp), 0.5 * Difference(right, sharp));
  EXPECT_LT(Difference(merged, sharp), 0.5 * Difference(left, sharp));
}

TEST(MergeFocusStack, OfOnePhotographTwiceIsThatPhotograph) {
  const Image8 sharp = Sharp(2);
  EXPECT_LT(Difference(MergeFocusStack({sharp, sharp}), sharp), 0.6);  // rounding of two pyramids
}

TEST(MergeFocusStack, HasTheSameBitsForAnyThreadCount) {
  const Image8 sharp = Sharp(3);
  const std::vector<Image8> stack = {Focused(sharp, true, 1.01), sharp,
                                     Focused(sharp, false, 0.99)};
  cv::setNumThreads(1);
  const Image8 one = MergeFocusStack(stack);
  cv::setNumThreads(3);
  EXPECT_EQ(MergeFocusStack(stack).data, one.data);
}

TEST(MergeFocusStack, RefusesWhatIsNoStack) {
  EXPECT_THROW(MergeFocusStack({Sharp(1)}), InputError);
  EXPECT_THROW(MergeFocusStack({Sharp(1), Image8(40, 30, 3)}), InputError);
  EXPECT_THROW(MergeFocusStack({Sharp(1), Sharp(4)}), InputError);  // other speckles
}

}  // namespace keypose::capture::shoot::focus_stack_test
