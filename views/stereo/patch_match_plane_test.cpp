#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "core/numbers/statistics.h"
#include "views/stereo/patch_match.h"

namespace keypose::stereo::patch_match_plane_test {

constexpr int kSize = 72;
constexpr double kDistance = 3;

// A plane through (0, 0, kDistance), turned about the vertical axis, painted with waves of 5 to 14
// pixels.
struct PaintedPlane {
  explicit PaintedPlane(double slant)
      : u(std::cos(slant), 0, -std::sin(slant)), normal(-std::sin(slant), 0, -std::cos(slant)) {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> unit(0, 1);
    for (Eigen::Vector3d& wave : waves) {
      const double angle = M_PI * unit(random),
                   frequency = 2 * M_PI / (0.033 * (5 + 9 * unit(random)));
      wave = {frequency * std::cos(angle), frequency * std::sin(angle), 2 * M_PI * unit(random)};
    }
  }
  double Depth(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) const {
    return normal.dot(Eigen::Vector3d(0, 0, kDistance) - from) / normal.dot(ray);
  }
  double Grey(const Eigen::Vector3d& x) const {
    const double a = u.dot(x - Eigen::Vector3d(0, 0, kDistance)), b = x.y();
    double grey = 128;
    const double contrast = faint_below && b > 0 ? 1.5 : 12;
    for (const Eigen::Vector3d& wave : waves)
      grey += contrast * std::sin(wave.x() * a + wave.y() * b + wave.z());
    return grey;
  }
  Eigen::Vector3d u, normal, waves[8];
  bool faint_below = false;  // an eighth of the contrast where y > 0
};

PreparedView Photograph(const PaintedPlane& plane, const Eigen::Vector3d& center,
                        double noise = 0) {
  std::mt19937 random(static_cast<unsigned>(1000 * (center.x() + 2 * center.y()) + 5000));
  std::normal_distribution<double> gauss(0, 1);
  View view;
  view.name = "plane.png";
  view.camera = {
      .width = kSize, .height = kSize, .fx = 90, .fy = 90, .cx = kSize / 2.0, .cy = kSize / 2.0};
  const Eigen::Vector3d forward = (Eigen::Vector3d(0, 0, kDistance) - center).normalized();
  view.camera_from_world.rotation =
      Eigen::Quaterniond::FromTwoVectors(forward, Eigen::Vector3d::UnitZ());
  view.camera_from_world.translation = -(view.camera_from_world.rotation * center);
  Image8 image(kSize, kSize, 3);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      double sum = 0;
      for (int k = 0; k < 9; ++k) {
        const Eigen::Vector3d ray =
            view.camera_from_world.rotation.conjugate() *
            view.camera.Unproject({x + (k % 3 + 0.5) / 3, y + (k / 3 + 0.5) / 3});
        const double depth = plane.Depth(center, ray);
        sum += depth > 0 && depth < 12 ? plane.Grey(center + depth * ray) : 128;
      }
      const double grey = sum / 9 + noise * gauss(random);
      for (int c = 0; c < 3; ++c) image.at(x, y)[c] = static_cast<std::uint8_t>(std::lround(grey));
    }
  return PrepareView(view, 0, image, Image8(kSize, kSize, 1, 255), 1, 2);
}

DepthBounds WideBounds() {
  DepthBounds bounds{1, ImageF(kSize / 2, kSize / 2, 1), ImageF(kSize / 2, kSize / 2, 1),
                     ImageF(kSize / 2, kSize / 2, 2)};
  std::fill(bounds.nearest.data.begin(), bounds.nearest.data.end(), 1 / 1.8f);
  std::fill(bounds.farthest.data.begin(), bounds.farthest.data.end(), 1 / 6.0f);
  return bounds;
}

// Half of the plane has an eighth of the other's contrast, and every photograph has its own noise.
TEST(EstimatePlanes, ExpectsLargerErrorsWhereTextureIsFaint) {
  PaintedPlane plane(20 * M_PI / 180);
  plane.faint_below = true;
  std::vector<PreparedView> views;
  for (const Eigen::Vector2d& at :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(0.5, 0), Eigen::Vector2d(-0.4, 0.1),
        Eigen::Vector2d(0.1, 0.5), Eigen::Vector2d(0, -0.5)})
    views.push_back(Photograph(plane, {at.x(), at.y(), 0}, 1.5));
  PatchMatchOptions options;
  options.geometric_passes = 0;
  const PatchMatchResult result =
      EstimatePlanes(views, {{1, 2, 3, 4}, {}, {}, {}, {}},
                     std::vector<DepthBounds>(5, WideBounds()), {}, options);
  const PlaneMap& map = result.maps[0];
  std::vector<double> errors[2], expected[2];
  for (int y = 12; y < kSize - 12; ++y)
    for (int x = 12; x < kSize - 12; ++x) {
      if (std::abs(y - kSize / 2) < 8) continue;  // windows that cover both halves
      const std::size_t pixel = map.Find(static_cast<std::size_t>(y) * map.width + x);
      const double depth = plane.Depth({0, 0, 0}, views[0].camera().Ray(x, y));
      errors[y > kSize / 2].push_back(std::abs(1 / map.InverseDepth(pixel) / depth - 1) *
                                      views[0].camera().fx);
      expected[y > kSize / 2].push_back(map.ExpectedError(pixel));
    }
  EXPECT_GT(UpperMedian(expected[1]), 2 * UpperMedian(expected[0]));
  // On a plane the coarser level is more accurate in the half with low contrast than its own
  // windows.
  for (int half = 0; half < 2; ++half)
    EXPECT_LT(UpperMedian(errors[half]), 3 * UpperMedian(expected[half])) << half;
}

TEST(EstimatePlanes, FindsDepthAndNormalOfPlanesUpToSeventyDegreesOfSlant) {
  for (const double degrees : {0.0, 20.0, 40.0, 60.0, 70.0}) {
    const PaintedPlane plane(degrees * M_PI / 180);
    std::vector<PreparedView> views = {Photograph(plane, {0, 0, 0})};

    for (const Eigen::Vector2d& at : {Eigen::Vector2d(0.5, 0), Eigen::Vector2d(-0.4, 0.1),
                                      Eigen::Vector2d(0.1, 0.5), Eigen::Vector2d(0, -0.5)})
      views.push_back(Photograph(plane, {at.x(), at.y(), 0}));
    PatchMatchOptions options;
    options.geometric_passes = 0;
    const PatchMatchResult result =
        EstimatePlanes(views, {{1, 2, 3, 4}, {}, {}, {}, {}},
                       std::vector<DepthBounds>(5, WideBounds()), {}, options);
    std::vector<double> depth_errors, angles;
    for (int y = kSize / 2 - 10; y < kSize / 2 + 10; ++y)
      for (int x = kSize / 2 - 10; x < kSize / 2 + 10; ++x) {
        const PlaneHypothesis found = result.maps[0].Plane(
            result.maps[0].Find(static_cast<std::size_t>(y) * result.maps[0].width + x));
        const double depth = plane.Depth({0, 0, 0}, views[0].camera().Ray(x, y));
        depth_errors.push_back(std::abs(1 / found.inverse_depth / depth - 1));
        const double cosine = PlaneNormal(views[0].camera(), x, y, found).dot(plane.normal);
        angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)) * 180 / M_PI);
      }
    // A displacement of a tenth of a pixel in the sources is 0.7 % of the depth.
    EXPECT_LT(UpperMedian(depth_errors), 0.007) << degrees << " degrees";
    EXPECT_LT(UpperMedian(angles), 6) << degrees << " degrees";
  }
}

}  // namespace keypose::stereo::patch_match_plane_test
