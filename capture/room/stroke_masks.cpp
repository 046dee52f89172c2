#include "capture/room/stroke_masks.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"
#include "capture/segmentation/set_rounds.h"
#include "capture/segmentation/trimap.h"

namespace keypose::capture {
namespace {

constexpr double kSeed = 0.02;    // of the longer side: what lies so near a stroke is of it
constexpr double kAround = 0.35;  // what lies farther from all strokes is not the figure
constexpr int kSalient = 127;     // of the network's 255

cv::Mat1b Marked(const std::vector<Eigen::Vector2i>& pixels, int width, int height, int radius) {
  cv::Mat1b marked(height, width, std::uint8_t{0});
  for (const Eigen::Vector2i& p : pixels)
    cv::circle(marked, {p.x(), p.y()}, radius, cv::Scalar(255), cv::FILLED);
  return marked;
}

/// The connected parts of a mask that meet a mark.
cv::Mat1b PartsUnder(const cv::Mat1b& mask, const cv::Mat1b& marked) {
  cv::Mat parts;
  const int count = cv::connectedComponents(mask, parts, 8, CV_32S);
  std::vector<char> hit(static_cast<std::size_t>(count), 0);
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (marked(y, x)) hit[static_cast<std::size_t>(parts.at<int>(y, x))] = 1;
  cv::Mat1b under(mask.size(), std::uint8_t{0});
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      const int part = parts.at<int>(y, x);
      under(y, x) = part > 0 && hit[static_cast<std::size_t>(part)] ? 255 : 0;
    }
  return under;
}

Image8 ByColours(const Image8& rgb, const cv::Mat1b& figure, const cv::Mat1b& other) {
  const double side = std::max(rgb.width, rgb.height);
  cv::Mat distance;
  cv::distanceTransform(figure == 0, distance, cv::DIST_L2, 3);
  Image8 trimap(rgb.width, rgb.height, 1, kUnknown);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x) {
      if (figure(y, x)) *trimap.at(x, y) = kObject;
      if (other(y, x) || distance.at<float>(y, x) > kAround * side) *trimap.at(x, y) = kBackground;
    }
  const MaskOptions options;
  const Image8 mask = SegmentByColor({rgb}, {trimap}, {{}}, options).front();
  return ImageOf(PartsUnder(cv::Mat1b(MatOf(mask) > kSalient), figure));
}

}  // namespace

Image8 MaskOfStrokes(const Image8& rgb, const Image8& salience, const ViewStrokes& strokes) {
  const int radius =
      std::max(1, static_cast<int>(std::lround(kSeed * std::max(rgb.width, rgb.height))));
  const cv::Mat1b figure = Marked(strokes.figure, rgb.width, rgb.height, radius),
                  other = Marked(strokes.other, rgb.width, rgb.height, radius);
  if (!salience.empty()) {
    const cv::Mat1b likely = MatOf(salience) > kSalient;
    cv::Mat1b seen = strokes.figure.empty() ? likely : PartsUnder(likely, figure);
    const cv::Mat1b wrong = PartsUnder(likely, other);
    if (strokes.figure.empty()) seen.setTo(0, wrong);
    const bool apart = cv::countNonZero(seen & wrong) == 0;
    const bool covers = cv::countNonZero(figure & ~seen) * 2 <= cv::countNonZero(figure);
    if (apart && covers && cv::countNonZero(seen) > 0) return ImageOf(seen);
  }
  if (strokes.figure.empty()) return {};
  return ByColours(rgb, figure, other);
}

bool TakesBothForOne(const Image8& salience, const ViewStrokes& strokes) {
  if (salience.empty() || strokes.figure.empty() || strokes.other.empty()) return false;
  const cv::Mat1b likely = MatOf(salience) > kSalient;
  const auto part = [&](const auto& of) {
    return PartsUnder(likely, Marked(of, salience.width, salience.height, 1));
  };
  return cv::countNonZero(part(strokes.figure) & part(strokes.other)) > 0;
}

}  // namespace keypose::capture
