#include "composite/locating/mattes/mattes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/numbers/statistics.h"
#include "core/values/size_of.h"

namespace keypose::composite {
namespace {

constexpr double kDeviations = 5, kLeastDifference = 10;  // grey levels
constexpr double kShadowColour = 0.06, kDarkest = 0.45;   // of a shadow, relative
constexpr double kLeastPart = 0.02;                       // of the largest part
constexpr double kLeastShare = 2e-4;                      // of the picture
constexpr int kGrabRounds = 3, kGrabSide = 900;

struct Exposure {
  std::array<double, 3> gain{1, 1, 1};
  double noise = 1;  ///< deviation of a channel's difference after the gain
};

/// From every seventh pixel. The figure covers less than half of the picture, or medians fail.
Exposure ExposureOf(const Image8& frame, const Image8& plate) {
  Exposure exposure;
  const std::size_t count = frame.data.size() / 3;
  std::vector<double> sizes;
  for (int c = 0; c < 3; ++c) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < count; i += 7)
      if (plate.data[3 * i + c] > 20 && plate.data[3 * i + c] < 245)
        ratios.push_back(frame.data[3 * i + c] / static_cast<double>(plate.data[3 * i + c]));
    if (!ratios.empty()) exposure.gain[c] = UpperMedian(ratios);
  }
  for (std::size_t i = 0; i < count; i += 7)
    sizes.push_back(std::abs(frame.data[3 * i + 1] - exposure.gain[1] * plate.data[3 * i + 1]));
  exposure.noise = std::max(0.7, 1.4826 * UpperMedian(sizes));
  return exposure;
}

/// Whether the pixel is the plate's, darkened evenly.
bool IsShadow(const std::uint8_t* a, const std::uint8_t* b, const Exposure& exposure) {
  std::array<double, 3> ratio;
  for (int c = 0; c < 3; ++c) {
    if (b[c] < 15) return false;
    ratio[c] = a[c] / (exposure.gain[c] * b[c]);
  }
  const auto [low, high] = std::minmax_element(ratio.begin(), ratio.end());
  return *high < 1 && *low > kDarkest && *high - *low < kShadowColour * (*high + *low) / 2;
}

/// Keeps parts that are not much smaller than the largest, and fills what lies inside of them.
void KeepLargeParts(cv::Mat& matte) {
  cv::Mat labels, stats, centres;
  const int parts = cv::connectedComponentsWithStats(matte, labels, stats, centres);
  int largest = 0;
  for (int i = 1; i < parts; ++i) largest = std::max(largest, stats.at<int>(i, cv::CC_STAT_AREA));
  const double least = std::max(kLeastPart * largest, kLeastShare * matte.rows * matte.cols);
  for (int y = 0; y < matte.rows; ++y)
    for (int x = 0; x < matte.cols; ++x) {
      const int label = labels.at<int>(y, x);
      if (label > 0 && stats.at<int>(label, cv::CC_STAT_AREA) < least)
        matte.at<std::uint8_t>(y, x) = 0;
    }
}

void FillSmallHoles(cv::Mat& matte) {
  cv::Mat inverse = 255 - matte, labels, stats, centres;
  const int parts = cv::connectedComponentsWithStats(inverse, labels, stats, centres, 4);
  const double most = 0.003 * cv::countNonZero(matte);  // larger ones are windows of the figure
  for (int y = 0; y < matte.rows; ++y)
    for (int x = 0; x < matte.cols; ++x) {
      const int label = labels.at<int>(y, x);
      if (label > 0 && label < parts && stats.at<int>(label, cv::CC_STAT_AREA) < most)
        matte.at<std::uint8_t>(y, x) = 255;
    }
}

cv::Mat Disk(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

Image8 ToImage(const cv::Mat& mat) {
  Image8 image(mat.cols, mat.rows, 1);
  for (int y = 0; y < mat.rows; ++y)
    std::copy_n(mat.ptr<std::uint8_t>(y), mat.cols, image.at(0, y));
  return image;
}

/// GrabCut's labels around a silhouette.
cv::Mat TrimapOf(const cv::Mat& covered, int within) {
  cv::Mat sure, around, far;
  cv::erode(covered, sure, Disk(within));
  cv::dilate(covered, around, Disk(within));
  cv::Mat trimap(covered.size(), CV_8U, cv::Scalar(cv::GC_BGD));
  trimap.setTo(cv::GC_PR_BGD, around);
  trimap.setTo(cv::GC_PR_FGD, covered);
  trimap.setTo(cv::GC_FGD, sure);
  return trimap;
}

/// The silhouette's box with room for background around it.
cv::Rect BoxAround(const cv::Mat& covered, int within) {
  cv::Rect box = cv::boundingRect(covered);
  const int margin = 4 * within + std::max(box.width, box.height) / 6;
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin);
  return box & cv::Rect(0, 0, covered.cols, covered.rows);
}

}  // namespace

Image8 MatteFromPlate(const Image8& frame, const Image8& plate) {
  const Exposure exposure = ExposureOf(frame, plate);
  const double least = std::max(kLeastDifference, kDeviations * exposure.noise);
  cv::Mat matte(frame.height, frame.width, CV_8U, cv::Scalar(0));
  for (int y = 0; y < frame.height; ++y)
    for (int x = 0; x < frame.width; ++x) {
      const std::uint8_t *a = frame.at(x, y), *b = plate.at(x, y);
      double difference = 0;
      for (int c = 0; c < 3; ++c)
        difference = std::max(difference, std::abs(a[c] - exposure.gain[c] * b[c]));
      if (difference > least && !IsShadow(a, b, exposure)) matte.at<std::uint8_t>(y, x) = 255;
    }
  cv::morphologyEx(matte, matte, cv::MORPH_CLOSE, Disk(2));
  cv::morphologyEx(matte, matte, cv::MORPH_OPEN, Disk(2));
  KeepLargeParts(matte);
  FillSmallHoles(matte);
  return ToImage(matte);
}

Image8 MatteByColours(const Image8& picture, const Image8& covered, int within_px) {
  const cv::Mat colours(picture.height, picture.width, CV_8UC3,
                        const_cast<std::uint8_t*>(picture.data.data()));
  const cv::Mat mesh(covered.height, covered.width, CV_8U,
                     const_cast<std::uint8_t*>(covered.data.data()));
  if (cv::countNonZero(mesh) == 0) return covered;
  const cv::Rect box = BoxAround(mesh, within_px);
  const double scale =
      std::min(1.0, static_cast<double>(kGrabSide) / std::max(box.width, box.height));
  cv::Mat small, small_mesh, background, foreground;
  cv::resize(colours(box), small, {}, scale, scale, cv::INTER_AREA);
  cv::resize(mesh(box), small_mesh, small.size(), 0, 0, cv::INTER_AREA);
  small_mesh = small_mesh > 127;
  cv::Mat labels =
      TrimapOf(small_mesh, std::max(2, static_cast<int>(std::lround(within_px * scale))));
  if (cv::countNonZero(labels == cv::GC_FGD) < 50) return covered;
  cv::theRNG().state = 1;
  cv::grabCut(small, labels, {}, background, foreground, kGrabRounds, cv::GC_INIT_WITH_MASK);
  cv::Mat found = ((labels == cv::GC_FGD) | (labels == cv::GC_PR_FGD)), large;
  cv::resize(found, large, box.size(), 0, 0, cv::INTER_LINEAR);
  cv::Mat matte(covered.height, covered.width, CV_8U, cv::Scalar(0));
  large.copyTo(matte(box));
  return ToImage(matte);
}

}  // namespace keypose::composite
