#include "capture/shoot/develop/white_balance.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "capture/pictures/cv_image.h"
#include "capture/pictures/working_image.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"

namespace keypose::capture::shoot {
namespace {

std::string Text(const PixelBox& box) {
  return std::to_string(box.x) + "," + std::to_string(box.y) + "," + std::to_string(box.width) +
         "," + std::to_string(box.height);
}

void RequireInside(const Image8& image, const PixelBox& box) {
  constexpr int kLeast_px = 4;
  const bool inside = box.x >= 0 && box.y >= 0 && box.width >= kLeast_px &&
                      box.height >= kLeast_px && box.width <= image.width - box.x &&
                      box.height <= image.height - box.y;
  if (!inside)
    throw InputError("white balance: the place " + Text(box) +
                     " (x,y,width,height) is not within " + std::to_string(image.width) + " x " +
                     std::to_string(image.height) +
                     " pixels, or smaller than 4 pixels; give the place of the grey card");
}

/// Components of a mask that look like a card, largest first.
cv::Rect LargestRectangle(const cv::Mat& even) {
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(even, labels, stats, centres, 4);
  const double least = 0.002 * even.total();
  cv::Rect best;
  for (int i = 1; i < count; ++i) {
    const cv::Rect box(stats.at<int>(i, cv::CC_STAT_LEFT), stats.at<int>(i, cv::CC_STAT_TOP),
                       stats.at<int>(i, cv::CC_STAT_WIDTH), stats.at<int>(i, cv::CC_STAT_HEIGHT));
    const double area = stats.at<int>(i, cv::CC_STAT_AREA);
    const bool at_border =
        box.x <= 1 || box.y <= 1 || box.br().x >= even.cols - 1 || box.br().y >= even.rows - 1;
    if (area < least || at_border || area <= best.area()) continue;
    std::vector<cv::Point> pixels;
    cv::findNonZero(labels == i, pixels);
    const cv::RotatedRect around = cv::minAreaRect(pixels);
    const double sides = (around.size.width + 1.0) * (around.size.height + 1.0);
    const double longer = std::max(around.size.width, around.size.height);
    const double shorter = std::min(around.size.width, around.size.height);
    if (area < 0.85 * sides || longer > 4 * shorter) continue;
    // The middle third lies within the card, also of one that is turned.
    const cv::Point2f middle = around.center;
    const int reach = std::max(2, static_cast<int>(shorter / 3));
    best = cv::Rect(static_cast<int>(middle.x) - reach / 2, static_cast<int>(middle.y) - reach / 2,
                    reach, reach);
  }
  return best;
}

}  // namespace

WhiteGains GainsFromCard(const Image8& image, const PixelBox& box) {
  RequireInside(image, box);
  std::array<double, 3> sum{};
  double burnt = 0;
  for (int y = box.y; y < box.y + box.height; ++y)
    for (int x = box.x; x < box.x + box.width; ++x) {
      const std::uint8_t* pixel = image.at(x, y);
      burnt += *std::max_element(pixel, pixel + 3) >= 253;
      for (int c = 0; c < 3; ++c) sum[c] += kLinearDouble[pixel[c]];
    }
  const double count = static_cast<double>(box.width) * box.height;
  const double brightest = *std::max_element(sum.begin(), sum.end()) / count;
  const double darkest = *std::min_element(sum.begin(), sum.end()) / count;
  if (burnt > 0.02 * count)
    throw InputError("white balance: the card at " + Text(box) +
                     " is burnt out; photograph it with less light or a shorter exposure");
  if (brightest < 0.01 || darkest < 0.2 * brightest)
    throw InputError("white balance: the place " + Text(box) +
                     " is too dark or too coloured for a grey card; give the card's place");
  return {sum[1] / sum[0], 1, sum[1] / sum[2]};
}

std::optional<PixelBox> FindCard(const Image8& image) {
  constexpr int kWorking_px = 400;
  constexpr int kEven = 10;       // difference of neighbours, of three pixels [grey levels]
  constexpr double kColour = 30;  // from grey [8 bit Lab]; a lamp's tint stays below
  const Image8 small = WorkingImage(image, kWorking_px);
  cv::Mat smooth, lab, highest, lowest;
  cv::GaussianBlur(MatOf(small), smooth, {3, 3}, 0);
  cv::cvtColor(smooth, lab, cv::COLOR_RGB2Lab);
  const cv::Mat square = cv::Mat::ones(3, 3, CV_8U);
  cv::dilate(smooth, highest, square);
  cv::erode(smooth, lowest, square);
  cv::Mat even(smooth.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < even.rows; ++y)
    for (int x = 0; x < even.cols; ++x) {
      const cv::Vec3b spread = highest.at<cv::Vec3b>(y, x) - lowest.at<cv::Vec3b>(y, x);
      const cv::Vec3b colour = lab.at<cv::Vec3b>(y, x);
      const double from_grey = std::hypot(colour[1] - 128.0, colour[2] - 128.0);
      const bool lit = colour[0] > 60 && colour[0] < 245;
      if (std::max({spread[0], spread[1], spread[2]}) <= kEven && lit && from_grey < kColour)
        even.at<std::uint8_t>(y, x) = 255;
    }
  const cv::Rect box = LargestRectangle(even);
  if (box.area() == 0) return std::nullopt;
  const double scale = static_cast<double>(image.width) / small.width;
  const auto up = [&](int value) { return static_cast<int>(value * scale); };
  return PixelBox{up(box.x), up(box.y), std::max(4, up(box.width)), std::max(4, up(box.height))};
}

namespace {

template <class T>
ImageT<T> Balanced(const ImageT<T>& image, const WhiteGains& gains) {
  constexpr int kMost = std::numeric_limits<T>::max();
  std::array<std::vector<T>, 3> table;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i <= kMost; ++i) {
      const double value =
          SrgbFromLinear(std::min(1.0, gains[c] * LinearFromSrgb(i / double{kMost})));
      table[c].push_back(static_cast<T>(std::lround(kMost * value)));
    }
  ImageT<T> out = image;
  for (std::size_t i = 0; i < out.data.size(); ++i) out.data[i] = table[i % 3][out.data[i]];
  return out;
}

}  // namespace

Image8 WithGains(const Image8& image, const WhiteGains& gains) { return Balanced(image, gains); }
Image16 WithGains(const Image16& image, const WhiteGains& gains) { return Balanced(image, gains); }

}  // namespace keypose::capture::shoot
