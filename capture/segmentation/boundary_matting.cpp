#include "capture/segmentation/boundary_matting.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "capture/pictures/cv_image.h"
#include "core/pictures/srgb.h"
#include "core/values/tuned.h"

namespace keypose::capture {
namespace {

constexpr float kPure = 1, kFarthest = 5;  // distances outside of the border, in pixels, between
                                           // which the background is unmixed and still near
// The same inside of it: a surface that curves away from the light gets dark towards its border.
constexpr float kOwn = 0.6F, kShaded = 2.1F;
constexpr int kWindowReach = 5;  // of the window of samples
constexpr double kSigma = 1.5;   // of the window's weights, pixels

// Tuned on the synthetic rings of weak and rich texture, 36 photographs of 1440 x 1080
// (docs/algorithms/masks.md). Sensitivity: docs/results/sensitivity.md.
struct BoundaryMattingTuning {
  KEYPOSE_TUNED(float, kBand, 1.5F);  // px beside the border, decided again
  // between the two sides, as a share of full linear light
  KEYPOSE_TUNED(double, kLeastContrast, 15.0 / 255);
  KEYPOSE_TUNED(double, kLeastRatio, 4);  // squared contrast over the variances of both sides
};

/// Weighted mean and variance of colours.
struct Colors {
  double weight = 0, squares = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();

  void Add(const Eigen::Vector3d& color, double w) {
    weight += w;
    sum += w * color;
    squares += w * color.squaredNorm();
  }
  Eigen::Vector3d Mean() const { return sum / weight; }
  double Variance() const { return std::max(0.0, squares / weight - Mean().squaredNorm()); }
};

/// Distance in pixels from the mask's border, positive inside; the border is half a pixel outside
/// of the outermost pixels.
cv::Mat FromBorder(const cv::Mat& mask) {
  cv::Mat inside, outside;
  cv::distanceTransform(mask, inside, cv::DIST_L2, cv::DIST_MASK_5);
  cv::distanceTransform(mask == 0, outside, cv::DIST_L2, cv::DIST_MASK_5);
  cv::Mat distance = inside - outside;
  distance.forEach<float>([](float& value, const int*) { value -= std::copysign(0.5F, value); });
  return distance;
}

class Boundary {
 public:
  Boundary(const cv::Mat& image, const cv::Mat& mask) : image_(image), distance_(FromBorder(mask)) {
    for (int k = 0; k <= kWindowReach; ++k) window_[k] = std::exp(-0.5 * k * k / (kSigma * kSigma));
  }

  bool Near(int x, int y) const {
    return std::abs(distance_.at<float>(y, x)) < BoundaryMattingTuning::kBand;
  }

  /// Whether the object covers more than half of a pixel; `now` if that is not determined.
  bool Covered(int x, int y, bool now) const {
    Colors object, background;
    for (int v = std::max(0, y - kWindowReach); v <= std::min(image_.rows - 1, y + kWindowReach);
         ++v)
      for (int u = std::max(0, x - kWindowReach); u <= std::min(image_.cols - 1, x + kWindowReach);
           ++u) {
        const float from = distance_.at<float>(v, u);
        const bool inside = from > kOwn && from < kShaded,
                   outside = from < -kPure && from > -kFarthest;
        if (!inside && !outside) continue;
        const double weight = window_[std::abs(u - x)] * window_[std::abs(v - y)];
        (inside ? object : background).Add(Color(u, v), weight);
      }
    if (object.weight <= 0 || background.weight <= 0) return now;
    const Eigen::Vector3d way = object.Mean() - background.Mean();
    const double contrast = way.squaredNorm();
    if (contrast < BoundaryMattingTuning::kLeastContrast * BoundaryMattingTuning::kLeastContrast ||
        contrast < BoundaryMattingTuning::kLeastRatio * (object.Variance() + background.Variance()))
      return now;
    return (Color(x, y) - background.Mean()).dot(way) > 0.5 * contrast;
  }

 private:
  Eigen::Vector3d Color(int x, int y) const {
    const cv::Vec3b& rgb = image_.at<cv::Vec3b>(y, x);
    return {kLinear[rgb[0]], kLinear[rgb[1]], kLinear[rgb[2]]};
  }

  cv::Mat image_, distance_;
  std::array<double, kWindowReach + 1> window_{};
};

/// Whether all four neighbours of a pixel differ from it: noise.
bool Alone(const Image8& mask, int x, int y) {
  if (x == 0 || y == 0 || x == mask.width - 1 || y == mask.height - 1) return false;
  const std::uint8_t here = *mask.at(x, y);
  return *mask.at(x - 1, y) != here && *mask.at(x + 1, y) != here && *mask.at(x, y - 1) != here &&
         *mask.at(x, y + 1) != here;
}

}  // namespace

void MatteBoundary(const Image8& image, Image8& mask) {
  cv::Mat all = MatOf(mask);
  cv::Rect box = cv::boundingRect(all);
  if (box.empty()) return;
  constexpr int kMargin = 2 * kWindowReach;
  box = cv::Rect(box.x - kMargin, box.y - kMargin, box.width + 2 * kMargin,
                 box.height + 2 * kMargin) &
        cv::Rect({0, 0}, all.size());
  const cv::Mat here = all(box);
  const Boundary boundary(MatOf(image)(box), here);
  std::vector<std::pair<cv::Point, std::uint8_t>> decided;
  for (int y = 0; y < here.rows; ++y)
    for (int x = 0; x < here.cols; ++x)
      if (boundary.Near(x, y)) {
        const std::uint8_t now = here.at<std::uint8_t>(y, x);
        decided.push_back(
            {{x, y}, boundary.Covered(x, y, now != 0) ? std::uint8_t{255} : std::uint8_t{0}});
      }
  for (const auto& [at, value] : decided) *mask.at(at.x + box.x, at.y + box.y) = value;
  for (const auto& [at, value] : decided)
    if (Alone(mask, at.x + box.x, at.y + box.y))
      *mask.at(at.x + box.x, at.y + box.y) = value ? std::uint8_t{0} : std::uint8_t{255};
}

}  // namespace keypose::capture
