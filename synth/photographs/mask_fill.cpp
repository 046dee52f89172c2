#include "synth/photographs/mask_fill.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "synth/worlds/noise.h"

namespace keypose::synth {
namespace {

using Eigen::Vector2d;

void FillMaskTriangle(const Vector2d& a, const Vector2d& b, const Vector2d& c, Image8* mask) {
  // Rows between the corners, and in each the span between the two edges that cross it.
  const Vector2d* p[3] = {&a, &b, &c};
  const double low = std::min({a.y(), b.y(), c.y()}), high = std::max({a.y(), b.y(), c.y()});
  const int y0 = std::max(0, static_cast<int>(std::ceil(low - 0.5)));
  const int y1 = std::min(mask->height - 1, static_cast<int>(std::floor(high - 0.5)));
  for (int y = y0; y <= y1; ++y) {
    const double at = y + 0.5;
    double from = 1e30, to = -1e30;
    for (int k = 0; k < 3; ++k) {
      const Vector2d &u = *p[k], &v = *p[(k + 1) % 3];
      if ((u.y() <= at) == (v.y() <= at)) continue;
      const double x = u.x() + (at - u.y()) / (v.y() - u.y()) * (v.x() - u.x());
      from = std::min(from, x);
      to = std::max(to, x);
    }
    const int x0 = std::max(0, static_cast<int>(std::ceil(from - 0.5)));
    const int x1 = std::min(mask->width - 1, static_cast<int>(std::floor(to - 0.5)));
    if (x0 <= x1) std::fill(mask->at(x0, y), mask->at(x1, y) + 1, std::uint8_t{255});
  }
}

// Signed distance [px], negative inside, in a frame around the mask.
cv::Mat SignedMaskDistance(const cv::Mat& mask) {
  cv::Mat inside, outside, inverse;
  cv::bitwise_not(mask, inverse);
  cv::distanceTransform(mask, inside, cv::DIST_L2, cv::DIST_MASK_5);
  cv::distanceTransform(inverse, outside, cv::DIST_L2, cv::DIST_MASK_5);
  return outside - inside;
}

}  // namespace

Image8 FillMask(const PointsX3& points, const FacesX3& faces, const View& view) {
  Image8 mask(view.camera.width, view.camera.height, 1);
  std::vector<Vector2d> pixels(static_cast<std::size_t>(points.rows()));
  std::vector<char> visible(pixels.size());
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const Eigen::Vector3d x = view.camera_from_world * points.row(v).transpose();
    visible[v] = x.z() > 0.01;
    if (visible[v]) pixels[v] = view.camera.Project(x);
  }
  for (Eigen::Index f = 0; f < faces.rows(); ++f) {
    const int a = faces(f, 0), b = faces(f, 1), c = faces(f, 2);
    if (visible[a] && visible[b] && visible[c])
      FillMaskTriangle(pixels[a], pixels[b], pixels[c], &mask);
  }
  return mask;
}

Image8 NoisyMask(const Image8& mask, double noise_px, std::uint64_t seed) {
  if (noise_px <= 0) return mask;
  constexpr double kWave = 7;       // [px] of the noise's lattice
  constexpr double kSpread = 0.26;  // standard deviation of GradientNoise in a plane
  const cv::Mat source(mask.height, mask.width, CV_8U, const_cast<std::uint8_t*>(mask.data.data()));
  const cv::Mat distance = SignedMaskDistance(source);
  Image8 noisy = mask;
  const double most = 4 * noise_px;
  for (int y = 0; y < mask.height; ++y)
    for (int x = 0; x < mask.width; ++x) {
      const double d = distance.at<float>(y, x);
      if (std::abs(d) > most) continue;
      const double n = noise_px / kSpread *
                       GradientNoise(Eigen::Vector3d(x / kWave, y / kWave, 0.37),
                                     static_cast<std::uint32_t>(Hash(seed)));
      *noisy.at(x, y) = d < n ? 255 : 0;
    }
  return noisy;
}

}  // namespace keypose::synth
