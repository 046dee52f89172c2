#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "reconstruct/patch_match.h"

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 72;
constexpr double kDistance = 3;

// A plane through (0, 0, kDistance), turned about the vertical axis, painted with waves of 5 to 14 pixels.
struct PaintedPlane {
  explicit PaintedPlane(double slant) : u(std::cos(slant), 0, -std::sin(slant)), normal(-std::sin(slant), 0, -std::cos(slant)) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (Eigen::Vector3d& wave : waves) {
      const double angle = M_PI * unit(random), frequency = 2 * M_PI / (0.033 * (5 + 9 * unit(random)));
      wave = {frequency * std::cos(angle), frequency * std::sin(angle), 2 * M_PI * unit(random)};
    }
  }
  double Depth(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    return normal.dot(Eigen::Vector3d(0, 0, kDistance) - from) / normal.dot(ray);
  }
  double Grey(const Eigen::Vector3d& x) const {
    const double a = u.dot(x - Eigen::Vector3d(0, 0, kDistance)), b = x.y();
    double grey = 128;
    for (const Eigen::Vector3d& wave : waves) grey += 12 * std::sin(wave.x() * a + wave.y() * b + wave.z());
    return grey;
  }
  Eigen::Vector3d u, normal, waves[8];
};

DenseView Photograph(const PaintedPlane& plane, const Eigen::Vector3d& center) {
  View view;
  view.name = "plane.png";
  view.camera = {.width = kSize, .height = kSize, .fx = 90, .fy = 90, .cx = kSize / 2.0, .cy = kSize / 2.0};
  const Eigen::Vector3d forward = (Eigen::Vector3d(0, 0, kDistance) - center).normalized();
  view.camera_from_world.rotation = Eigen::Quaterniond::FromTwoVectors(forward, Eigen::Vector3d::UnitZ());
  view.camera_from_world.translation = -(view.camera_from_world.rotation * center);
  Image8 image(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) {
        const Eigen::Vector3d ray =
            view.camera_from_world.rotation.conjugate() * view.camera.Unproject({x + (k % 3 + 0.5) / 3, y + (k / 3 + 0.5) / 3});
        const double depth = plane.Depth(center, ray);
        sum += depth > 0 && depth < 12 ? plane.Grey(center + depth * ray) : 128;
      }
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(sum / 9));
    }
  return PrepareDenseView(view, 0, image, Image8(kSize, kSize, 1, 255), 1, 2);
}

double Median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

TEST(EstimatePlanes, FindsDepthAndNormalOfPlanesUpToSeventyDegreesOfSlant) {
  for (const double degrees : {0.0, 20.0, 40.0, 60.0, 70.0}) {
    const PaintedPlane plane(degrees * M_PI / 180);
    std::vector<DenseView> views = {Photograph(plane, {0, 0, 0})};

    for (const Eigen::Vector2d& at :
         {Eigen::Vector2d(0.5, 0), Eigen::Vector2d(-0.4, 0.1), Eigen::Vector2d(0.1, 0.5), Eigen::Vector2d(0, -0.5)})
      views.push_back(Photograph(plane, {at.x(), at.y(), 0}));
    DepthBounds bounds{1, ImageF(kSize / 2, kSize / 2, 1), ImageF(kSize / 2, kSize / 2, 1), ImageF(kSize / 2, kSize / 2, 2)};
    std::fill(bounds.nearest.data.begin(), bounds.nearest.data.end(), 1 / 1.8f);
    std::fill(bounds.farthest.data.begin(), bounds.farthest.data.end(), 1 / 6.0f);
    PatchMatchOptions options;
    options.geometric_passes = 0;
    const PatchMatchResult result = EstimatePlanes(views, {{1, 2, 3, 4}, {}, {}, {}, {}}, std::vector<DepthBounds>(5, bounds), {}, options);
    std::vector<double> depth_errors, angles;
    for (int y = kSize / 2 - 10; y < kSize / 2 + 10; ++y)
      for (int x = kSize / 2 - 10; x < kSize / 2 + 10; ++x) {
        const PlaneHypothesis found = result.maps[0].Plane(static_cast<std::size_t>(y) * result.maps[0].width + x);
        const double depth = plane.Depth({0, 0, 0}, views[0].camera().Ray(x, y));
        depth_errors.push_back(std::abs(1 / found.inverse_depth / depth - 1));
        const double cosine = PlaneNormal(views[0].camera(), x, y, found).dot(plane.normal);
        angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI);
      }
    // A tenth of a pixel of motion in the sources is 0.7 % of the depth.
    EXPECT_LT(Median(depth_errors), 0.007) << degrees << " degrees";
    EXPECT_LT(Median(angles), 6) << degrees << " degrees";
  }
}

}  // namespace
}  // namespace keypose::reconstruct
