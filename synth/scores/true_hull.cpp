#include "synth/scores/true_hull.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

#include "core/values/errors.h"
#include "synth/worlds/polygonize.h"

namespace keypose::synth {
namespace {

/// Signed distance to a mask's outline [px], positive outside.
class Outline {
 public:
  explicit Outline(const Image8& mask) {
    cv::Mat inside(mask.height, mask.width, CV_8U), to_background, to_character;
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x)
        inside.at<std::uint8_t>(y, x) = *mask.at(x, y) > 127 ? 255 : 0;
    cv::distanceTransform(inside, to_background, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    cv::distanceTransform(255 - inside, to_character, cv::DIST_L2, cv::DIST_MASK_PRECISE);
    // Each distance transform is 1 at the first pixel of its side; the outline runs between the
    // pixels.
    distance_.create(mask.height, mask.width, CV_32F);
    for (int y = 0; y < mask.height; ++y)
      for (int x = 0; x < mask.width; ++x) {
        const float out = to_character.at<float>(y, x), in = to_background.at<float>(y, x);
        distance_.at<float>(y, x) = out > 0 ? out - 0.5f : 0.5f - in;
      }
  }
  /// Bilinear between pixel centres. Outside the image: the border's value plus the distance to the
  /// border.
  double At(const Eigen::Vector2d& pixel) const {
    const double x = std::clamp(pixel[0] - 0.5, 0.0, distance_.cols - 1.0),
                 y = std::clamp(pixel[1] - 0.5, 0.0, distance_.rows - 1.0);
    const int x0 = std::min(static_cast<int>(x), distance_.cols - 2),
              y0 = std::min(static_cast<int>(y), distance_.rows - 2);
    const double u = x - x0, v = y - y0;
    const auto d = [&](int dx, int dy) {
      return static_cast<double>(distance_.at<float>(y0 + dy, x0 + dx));
    };
    const double inside =
        (1 - v) * ((1 - u) * d(0, 0) + u * d(1, 0)) + v * ((1 - u) * d(0, 1) + u * d(1, 1));
    return inside + std::hypot(pixel[0] - 0.5 - x, pixel[1] - 0.5 - y);
  }

 private:
  cv::Mat distance_;
};

}  // namespace

Mesh HullOfMasks(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const Eigen::Vector3d& low, const Eigen::Vector3d& high, double spacing) {
  if (views.empty() || views.size() != masks.size())
    throw InputError("synth: a hull needs one mask per view; there are " +
                     std::to_string(views.size()) + " views and " + std::to_string(masks.size()) +
                     " masks");
  std::vector<Outline> outlines;
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (masks[i].width != views[i].camera.width || masks[i].height != views[i].camera.height ||
        masks[i].width < 2 || masks[i].height < 2)
      throw InputError("synth: the mask of " + views[i].name + " does not have its camera's size");
    outlines.emplace_back(masks[i]);
  }
  const auto distance = [&](const Eigen::Vector3d& x) {
    double worst = -std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < views.size(); ++i) {
      const Eigen::Vector3d local = views[i].camera_from_world * x;
      if (local[2] <= 0) continue;
      worst = std::max(
          worst, outlines[i].At(views[i].camera.Project(local)) * local[2] / views[i].camera.fx);
    }
    return worst;
  };
  return Polygonize(distance, low, high, spacing, 1.6);
}

}  // namespace keypose::synth
