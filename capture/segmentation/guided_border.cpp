#include "capture/segmentation/guided_border.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "capture/pictures/cv_image.h"

namespace keypose::capture {
namespace {

constexpr int kSmallRadius = 4;  // of the windows at the fraction of the size

cv::Mat Mean(const cv::Mat& values, int radius) {
  cv::Mat mean;
  cv::boxFilter(values, mean, CV_32F, {2 * radius + 1, 2 * radius + 1});
  return mean;
}

/// What the windows around each pixel hold.
struct WindowMeans {
  std::array<cv::Mat, 3> colour, with_mask;  // means of I and of I p
  std::array<cv::Mat, 6> products;           // of I I: 00 01 02 11 12 22
  cv::Mat mask;                              // of p
};

WindowMeans MeansOf(const cv::Mat& rgb, const cv::Mat& mask, int radius) {
  std::array<cv::Mat, 3> plane;
  cv::Mat values, p;
  rgb.convertTo(values, CV_32F);
  cv::split(values, plane.data());
  mask.convertTo(p, CV_32F);
  WindowMeans means;
  means.mask = Mean(p, radius);
  std::size_t next = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    means.colour[i] = Mean(plane[i], radius);
    means.with_mask[i] = Mean(plane[i].mul(p), radius);
    for (std::size_t j = i; j < 3; ++j)
      means.products[next++] = Mean(plane[i].mul(plane[j]), radius);
  }
  return means;
}

/// For each pixel a and b of q = a I + b, of all windows that it is in.
cv::Mat Coefficients(const cv::Mat& rgb, const cv::Mat& mask, int radius, float ridge) {
  const WindowMeans means = MeansOf(rgb, mask, radius);
  cv::Mat coefficients(rgb.size(), CV_32FC4);
  for (int y = 0; y < rgb.rows; ++y)
    for (int x = 0; x < rgb.cols; ++x) {
      const auto at = [&](const cv::Mat& mat) { return mat.at<float>(y, x); };
      const float p = at(means.mask);
      const Eigen::Vector3f mean(at(means.colour[0]), at(means.colour[1]), at(means.colour[2])),
          with_mask(at(means.with_mask[0]), at(means.with_mask[1]), at(means.with_mask[2]));
      Eigen::Matrix3f covariance;
      covariance << at(means.products[0]), at(means.products[1]), at(means.products[2]),
          at(means.products[1]), at(means.products[3]), at(means.products[4]),
          at(means.products[2]), at(means.products[4]), at(means.products[5]);
      covariance -= mean * mean.transpose();
      covariance.diagonal().array() += ridge;
      const Eigen::Vector3f a = covariance.inverse() * (with_mask - p * mean);
      coefficients.at<cv::Vec4f>(y, x) = {a.x(), a.y(), a.z(), p - a.dot(mean)};
    }
  return Mean(coefficients, radius);
}

/// The pixels between which one of the large picture lies along an axis.
struct Between {
  int first = 0, second = 0;
  float share = 0;  // of the second
};

std::vector<Between> PlacesBetween(int large, int small) {
  std::vector<Between> places(static_cast<std::size_t>(large));
  for (int k = 0; k < large; ++k) {
    const double at =
        std::clamp((k + 0.5) * small / large - 0.5, 0.0, static_cast<double>(small - 1));
    const int first = static_cast<int>(at);
    places[static_cast<std::size_t>(k)] = {first, std::min(first + 1, small - 1),
                                           static_cast<float>(at - first)};
  }
  return places;
}

/// Where a I + b is more than half, with coefficients interpolated to the picture's size.
void Decide(const cv::Mat& rgb, const cv::Mat& coefficients, cv::Mat mask) {
  const std::vector<Between> columns = PlacesBetween(rgb.cols, coefficients.cols),
                             rows = PlacesBetween(rgb.rows, coefficients.rows);
  std::vector<cv::Vec4f> row(static_cast<std::size_t>(coefficients.cols));
  for (int y = 0; y < rgb.rows; ++y) {
    const Between& v = rows[static_cast<std::size_t>(y)];
    const auto *upper = coefficients.ptr<cv::Vec4f>(v.first),
               *lower = coefficients.ptr<cv::Vec4f>(v.second);
    for (std::size_t k = 0; k < row.size(); ++k)
      for (int c = 0; c < 4; ++c) row[k][c] = upper[k][c] + v.share * (lower[k][c] - upper[k][c]);
    const cv::Vec3b* pixel = rgb.ptr<cv::Vec3b>(y);
    std::uint8_t* out = mask.ptr(y);
    for (int x = 0; x < rgb.cols; ++x) {
      const Between& h = columns[static_cast<std::size_t>(x)];
      const cv::Vec4f &left = row[static_cast<std::size_t>(h.first)],
                      &right = row[static_cast<std::size_t>(h.second)];
      const auto mixed = [&](int c) { return left[c] + h.share * (right[c] - left[c]); };
      const float q =
          mixed(0) * pixel[x][0] + mixed(1) * pixel[x][1] + mixed(2) * pixel[x][2] + mixed(3);
      out[x] = q > 127.5F ? 255 : 0;
    }
  }
}

}  // namespace

Image8 GuidedMask(const Image8& image, const Image8& mask, int radius, double noise) {
  Image8 guided(image.width, image.height, 1, 0);
  cv::Mat large;
  cv::resize(MatOf(mask), large, {image.width, image.height}, 0, 0, cv::INTER_LINEAR);
  // Two radii beyond the mask the result is zero for any picture.
  const int margin = 4 * radius;
  cv::Rect box = cv::boundingRect(large);
  if (box.empty()) return guided;
  box = cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) &
        cv::Rect({0, 0}, large.size());
  const double step = static_cast<double>(radius) / kSmallRadius;
  const cv::Size size(std::max(1, static_cast<int>(std::lround(box.width / step))),
                      std::max(1, static_cast<int>(std::lround(box.height / step))));
  cv::Mat small, small_mask;
  cv::resize(MatOf(image)(box), small, size, 0, 0, cv::INTER_AREA);
  cv::resize(large(box), small_mask, size, 0, 0, cv::INTER_AREA);
  const cv::Mat coefficients =
      Coefficients(small, small_mask, kSmallRadius, static_cast<float>(noise * noise));
  Decide(MatOf(image)(box), coefficients, MatOf(guided)(box));
  return guided;
}

}  // namespace keypose::capture
