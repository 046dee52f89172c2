#include "core/values/lens.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

namespace keypose::lens_test {

using Eigen::Vector2d;
using Eigen::Vector3d;
using enum LensProjection;

Lens Plain(LensProjection projection = kPerspective) {
  Lens lens;
  lens.model = "test";
  lens.width = 1280, lens.height = 720;
  lens.fx = 900, lens.fy = 890, lens.cx = 651.5, lens.cy = 349.5;
  lens.projection = projection;
  return lens;
}

Lens Brown(const std::vector<double>& d) {
  std::vector<double> all = d;
  all.resize(14);
  Lens lens = Plain();
  lens.radial = {all[0], all[1], all[4], 0, 0, 0};
  lens.p1 = all[2], lens.p2 = all[3];
  lens.divisor = {all[5], all[6], all[7]};
  lens.prism = {all[8], all[9], all[10], all[11]};
  lens.tilt = {all[12], all[13]};
  return lens;
}

/// OpenCV counts pixels from the centre of the first one.
cv::Mat MatrixOf(const Lens& lens) {
  return (cv::Mat_<double>(3, 3) << lens.fx, 0, lens.cx - 0.5, 0, lens.fy, lens.cy - 0.5, 0, 0, 1);
}

const std::vector<cv::Point3d> kPoints{{0, 0, 1},      {0.65, 0.36, 1}, {-0.5, 0.2, 1},
                                       {0.1, -0.3, 2}, {-1.3, -0.7, 2}, {0.001, 0, 1}};

/// The same pixels as OpenCV, and the same directions back.
void ExpectAsOpenCv(const Lens& lens, const std::vector<cv::Point2d>& pixels) {
  for (std::size_t i = 0; i < kPoints.size(); ++i) {
    const Vector3d x(kPoints[i].x, kPoints[i].y, kPoints[i].z);
    const auto seen = lens.Project(x);
    ASSERT_TRUE(seen);
    EXPECT_NEAR(seen->x(), pixels[i].x + 0.5, 1e-9) << i;
    EXPECT_NEAR(seen->y(), pixels[i].y + 0.5, 1e-9) << i;
    const auto ray = lens.Ray(*seen);
    ASSERT_TRUE(ray) << i;
    EXPECT_LT((*ray - x.normalized()).norm(), 1e-11) << i;
  }
}

TEST(Lens, MapsAsOpenCvDoes) {
  const std::vector<double> all{0.9,  0.2,  0.0006, -0.0004, 0.05, 1.05, 0.3,
                                0.01, 1e-3, 2e-3,   -1e-3,   3e-4, 0.02, -0.015};
  for (const std::size_t count : {4u, 5u, 8u, 12u, 14u}) {
    const std::vector<double> d(all.begin(), all.begin() + count);
    std::vector<cv::Point2d> pixels;
    cv::projectPoints(kPoints, cv::Vec3d(), cv::Vec3d(), MatrixOf(Brown(d)), d, pixels);
    SCOPED_TRACE(count);
    ExpectAsOpenCv(Brown(d), pixels);
  }
}

TEST(Lens, MapsAsOpenCvsFisheyeDoes) {
  Lens lens = Plain(kEquidistant);
  lens.radial = {0.12, -0.05, 0.02, -0.003, 0, 0};
  std::vector<cv::Point2d> pixels;
  cv::fisheye::projectPoints(kPoints, pixels, cv::Vec3d(), cv::Vec3d(), MatrixOf(lens),
                             cv::Vec4d(0.12, -0.05, 0.02, -0.003));
  ExpectAsOpenCv(lens, pixels);
}

// Numbers from a page that reported them: a rational lens, whose first two factors alone are
// absurd.
TEST(Lens, RationalFactorsGoTogether) {
  Lens lens = Brown({9.4, 21, 0, 0, 1.9, 9.55, 22.1, 3.3});
  const Vector2d seen = *lens.Project({0.65, 0.36, 1});
  EXPECT_NEAR((seen.x() - lens.cx) / lens.fx, 0.6187, 1e-4);
  EXPECT_NEAR((seen.y() - lens.cy) / lens.fy, 0.3427, 1e-4);
}

/// r of the projections, for an angle from the axis.
TEST(Lens, ProjectionsHaveTheirRadius) {
  const double theta = 0.7;
  const auto radius = [&](LensProjection projection, double a, double b) {
    Lens lens = Plain(projection);
    lens.shape = {a, b};
    return (lens.Project({0, std::sin(theta), std::cos(theta)})->y() - lens.cy) / lens.fy;
  };
  EXPECT_NEAR(radius(kPerspective, 0, 0), std::tan(theta), 1e-12);
  EXPECT_NEAR(radius(kEquidistant, 0, 0), theta, 1e-12);
  EXPECT_NEAR(radius(kEquisolid, 0, 0), 2 * std::sin(theta / 2), 1e-12);
  EXPECT_NEAR(radius(kStereographic, 0, 0), 2 * std::tan(theta / 2), 1e-12);
  EXPECT_NEAR(radius(kFieldOfView, 0.9, 0), std::atan(2 * std::tan(theta) * std::tan(0.45)) / 0.9,
              1e-12);
  EXPECT_NEAR(radius(kFieldOfView, 0, 0), std::tan(theta), 1e-12);
  const double r = radius(kDivision, -0.2, 0);
  EXPECT_NEAR(r / (1 - 0.2 * r * r), std::tan(theta), 1e-12);
  EXPECT_NEAR(radius(kUnified, 1, 0), std::tan(theta / 2), 1e-12);
  EXPECT_NEAR(radius(kEnhanced, 0, 1), std::tan(theta), 1e-12);
  EXPECT_NEAR(radius(kEnhanced, 0.5, 1), 2 * std::tan(theta / 2), 1e-12);
  EXPECT_NEAR(radius(kDoubleSphere, 0, 0.5), 2 * std::tan(theta / 2), 1e-12);
}

TEST(Lens, EveryPixelComesBack) {
  std::vector<Lens> lenses{Brown({-0.1, 0.03, 0.001, -0.002, -0.005})};
  for (const LensProjection projection : {kEquidistant, kEquisolid, kStereographic, kFieldOfView,
                                          kDivision, kUnified, kEnhanced, kDoubleSphere}) {
    Lens lens = Plain(projection);
    lens.shape = {0.6, 0.9};
    if (projection == kDivision) lens.shape[0] = -0.15;
    lens.radial = {0.02, -0.01, 0.003, 0, 0, 0};
    lens.p1 = 0.001, lens.p3 = 0.1, lens.skew = 2;
    lenses.push_back(lens);
    lens.radial_first = true;
    lens.prism = {1e-3, 0, -2e-3, 0};
    lenses.push_back(lens);
  }
  for (const Lens& lens : lenses)
    for (int x = 0; x <= 1280; x += 80)
      for (int y = 0; y <= 720; y += 80) {
        const auto ray = lens.Ray(Vector2d(x, y));
        ASSERT_TRUE(ray) << static_cast<int>(lens.projection) << " " << x << " " << y;
        EXPECT_NEAR(ray->norm(), 1, 1e-12);
        EXPECT_LT((*lens.Project(*ray) - Vector2d(x, y)).norm(), 1e-8);
      }
}

TEST(Lens, BeyondWhereThePolynomialTurnsBackNothingIsSeen) {
  const Lens lens = Brown({-0.5});  // r (1 - r^2 / 2) is at most 0.544, at r = 0.816
  EXPECT_TRUE(lens.Ray(Vector2d(lens.cx + 0.54 * lens.fx, lens.cy)));
  EXPECT_FALSE(lens.Ray(Vector2d(lens.cx + 0.55 * lens.fx, lens.cy)));
  EXPECT_FALSE(lens.Project({1, 0, -1}));
  EXPECT_FALSE(lens.Project({0, 0, 0}));
  EXPECT_TRUE(Plain(kEquidistant).Project({1, 0, -0.5})) << "fisheyes see behind";
}

TEST(CameraOf, IsExactWhereTheModelHoldsTheLens) {
  const Camera camera{640, 480, 500, 501, 320, 240, 0.01, -0.02, 1e-4, 2e-4};
  const auto back = CameraOf(LensOf(camera));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->k2, camera.k2);
  EXPECT_EQ(back->p2, camera.p2);
  EXPECT_EQ(back->fy, camera.fy);
  EXPECT_EQ(*LensOf(camera).Project({0.3, 0.2, 1}), camera.Project({0.3, 0.2, 1}));
}

double WorstMiss(const Camera& camera, const Lens& lens) {
  double worst = 0;
  for (int x = 0; x <= lens.width; x += 10)
    for (int y = 0; y <= lens.height; y += 10)
      worst = std::max(worst, (camera.Project(*lens.Ray(Vector2d(x, y))) - Vector2d(x, y)).norm());
  return worst;
}

TEST(CameraOf, StandsForLensesThatAreNearlyOne) {
  Lens k3 = Brown({-0.05, 0.02, 0.0004, -0.0003, -0.02});
  k3.fx = k3.fy = 1500;
  const auto camera = CameraOf(k3);
  ASSERT_TRUE(camera);
  EXPECT_LT(WorstMiss(*camera, k3), kSameLens_px);
  Lens fisheye = Plain(kEquidistant);
  fisheye.width = 400, fisheye.height = 300, fisheye.fx = fisheye.fy = 500;
  fisheye.cx = 200, fisheye.cy = 150;
  const auto narrow = CameraOf(fisheye);
  ASSERT_TRUE(narrow);
  EXPECT_LT(WorstMiss(*narrow, fisheye), kSameLens_px);
}

TEST(CameraOf, IsNoneWhereNoCameraIsNear) {
  EXPECT_FALSE(CameraOf(Plain(kEquidistant)));
  Lens skewed = Plain();
  skewed.skew = 3;
  EXPECT_FALSE(CameraOf(skewed));
  EXPECT_FALSE(CameraOf(Brown({9.4, 21, 0.0006, -0.0004, 1.9, 9.55, 22.1, 3.3})));
  Lens sizeless = Plain(kEquidistant);
  sizeless.width = sizeless.height = 0;
  sizeless.cx = sizeless.cy = 0;
  EXPECT_FALSE(CameraOf(sizeless));
}

TEST(UndistortedCamera, HasTheScaleOfTheMiddle) {
  Lens lens = Plain(kUnified);
  lens.shape = {1, 0};
  EXPECT_NEAR(UndistortedCamera(lens).fx, 450, 1e-3);
  EXPECT_NEAR(UndistortedCamera(lens).cx, lens.cx, 1e-9);
}

}  // namespace keypose::lens_test
