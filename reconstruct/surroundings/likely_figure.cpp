#include "reconstruct/surroundings/likely_figure.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace keypose::reconstruct {
namespace {

constexpr double kMiddle = 0.4;    // of the longer side: the spread of where people aim
constexpr double kNear = 0.15;     // of the longer side: the spread around the mask
constexpr double kOutside = 0.25;  // just outside of the mask

/// Distances to the mask in its pixels; empty where there is none.
cv::Mat1f DistanceField(const Image8& mask) {
  if (mask.empty()) return {};
  const cv::Mat all(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data.data()));
  const cv::Mat outside = all <= 127;
  if (cv::countNonZero(outside) == static_cast<int>(outside.total())) return {};
  cv::Mat1f distance;
  cv::distanceTransform(outside, distance, cv::DIST_L2, 3);
  return distance;
}

}  // namespace

Eigen::VectorXf DistanceToMask(const Features& features, int width, const Image8& mask) {
  const cv::Mat1f field = DistanceField(mask);
  Eigen::VectorXf away =
      Eigen::VectorXf::Constant(features.count(), std::numeric_limits<float>::max());
  if (field.empty()) return away;
  const double scale = static_cast<double>(mask.width) / width;
  for (int f = 0; f < features.count(); ++f) {
    const Eigen::Vector2d x = scale * features.positions.row(f).transpose().cast<double>();
    const int px = std::clamp(static_cast<int>(x.x()), 0, mask.width - 1),
              py = std::clamp(static_cast<int>(x.y()), 0, mask.height - 1);
    away(f) = static_cast<float>(field(py, px) / scale);
  }
  return away;
}

Eigen::VectorXf LikelyOnFigure(const Features& features, int width, int height,
                               const Image8& mask) {
  const double side = std::max(width, height);
  const Eigen::VectorXf away = DistanceToMask(features, width, mask);
  const bool masked = features.count() > 0 && away.minCoeff() < std::numeric_limits<float>::max();
  Eigen::VectorXf likely(features.count());
  for (int f = 0; f < features.count(); ++f) {
    const Eigen::Vector2d x = features.positions.row(f).transpose().cast<double>();
    const double off = (x - Eigen::Vector2d(width, height) / 2).norm() / side;
    double value = std::exp(-std::pow(off / kMiddle, 2));
    if (masked && away(f) > 0)
      value *= kOutside * std::exp(-std::pow(static_cast<double>(away(f)) / (kNear * side), 2));
    likely(f) = static_cast<float>(value);
  }
  return likely;
}

}  // namespace keypose::reconstruct
