#include "capture/pictures/photograph_quality.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

/// The blur effect along one axis: the share of neighbouring differences that remains after a box
/// blur of nine pixels.
double BlurEffect(const cv::Mat& grey, const cv::Mat& mask, bool along_x) {
  cv::Mat blurred;
  cv::blur(grey, blurred, along_x ? cv::Size(9, 1) : cv::Size(1, 9));
  const auto differences = [along_x](const cv::Mat& image) {
    const cv::Rect first(0, 0, image.cols - along_x, image.rows - !along_x),
        second(along_x, !along_x, first.width, first.height);
    return cv::Mat(cv::abs(image(second) - image(first)));
  };
  const cv::Mat before = differences(grey), after = differences(blurred);
  const cv::Mat inside = mask(cv::Rect(0, 0, before.cols, before.rows));
  const cv::Mat lost = cv::max(before - after, 0);
  const double total = cv::sum(cv::Mat(before.mul(inside)))[0],
               gone = cv::sum(cv::Mat(lost.mul(inside)))[0];
  return total <= 0 ? 1 : (total - gone) / total;
}

/// The box and the pixels beside it that filters reach.
cv::Rect WithReach(const cv::Rect& box, const cv::Size& size) {
  constexpr int kReach = 8;
  return cv::Rect(box.x - kReach, box.y - kReach, box.width + 2 * kReach, box.height + 2 * kReach) &
         cv::Rect({0, 0}, size);
}

}  // namespace

PhotographQuality MeasureQuality(const Image8& grey, const Image8& mask) {
  cv::Mat all = mask.empty() ? cv::Mat(grey.height, grey.width, CV_8U, cv::Scalar(255))
                             : cv::Mat(MatOf(mask) > 127);
  // Excludes the object's outline, which is an edge of the mask and not of the texture.
  cv::Mat core;
  cv::erode(all, core, cv::getStructuringElement(cv::MORPH_ELLIPSE, {7, 7}));
  if (cv::countNonZero(core) > 100) all = core;
  if (cv::countNonZero(all) == 0) all.setTo(255);
  const cv::Rect box = WithReach(cv::boundingRect(all), all.size());
  const cv::Mat inside = all(box), pixels = MatOf(grey)(box);
  cv::Mat laplacian, values, weight;
  cv::Laplacian(pixels, laplacian, CV_32F);
  cv::Scalar mean, deviation;
  cv::meanStdDev(laplacian, mean, deviation, inside);
  pixels.convertTo(values, CV_32F);
  inside.convertTo(weight, CV_32F, 1 / 255.0);
  PhotographQuality quality;
  quality.laplacian_variance = deviation[0] * deviation[0];
  quality.crispness =
      1 - std::max(BlurEffect(values, weight, true), BlurEffect(values, weight, false));
  quality.exposure = cv::mean(pixels, inside)[0];
  const cv::Mat clipped = ((pixels <= 2) | (pixels >= 253)) & inside;
  quality.clipped = static_cast<double>(cv::countNonZero(clipped)) / cv::countNonZero(inside);
  return quality;
}

}  // namespace keypose::capture
