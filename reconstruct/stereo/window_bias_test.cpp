#include "reconstruct/stereo/window_bias.h"

#include <gtest/gtest.h>

#include <cmath>

namespace keypose::reconstruct::window_bias_test {

constexpr int kSize = 64;
constexpr double kVariance = 16;
const Pinhole kCamera{kSize, kSize, 500, 500, 31.5, 31.5};

// Inverse depth 0.5, slanted, and bent by kx and ky [1 / pixel^2 of depth in pixels] along x and y.
double Bent(double x, double y, double kx, double ky) {
  const double u = x - 30, v = y - 28, unit = 0.5 / kCamera.fx;  // a pixel of depth
  return 0.5 + unit * (0.4 * u - 0.3 * v + 0.5 * (kx * u * u + ky * v * v));
}

template <class Depth>
stereo::PlaneMap MapOf(const Depth& inverse_depth) {
  stereo::PlaneMap map(kCamera, 8);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * kSize + x;
      map.SetPlane(i, {static_cast<float>(inverse_depth(x, y)), 0, 0});
      map.SetCost(i, 0.1f), map.SetExpectedError(i, 0.2f);
    }
  return map;
}

// Difference between a map's pixel and an inverse depth, in pixels of depth.
double Off(const stereo::PlaneMap& map, int x, int y, double inverse_depth) {
  return (map.InverseDepth(static_cast<std::size_t>(y) * kSize + x) - inverse_depth) * kCamera.fx /
         0.5;
}

TEST(WindowBias, MeansOverWindowsOfACurvedSurfaceBecomeItsDepths) {
  for (const Eigen::Vector2d& bend :
       {Eigen::Vector2d(0.02, 0.03), Eigen::Vector2d(-0.03, 0.0), Eigen::Vector2d(0.02, -0.02)}) {
    const double kx = bend.x(), ky = bend.y();
    // of the window's samples, above their mean
    const double mean_above = 0.5 * kVariance * (kx + ky);
    stereo::PlaneMap map =
        MapOf([&](int x, int y) { return Bent(x, y, kx, ky) + mean_above * 0.5 / kCamera.fx; });
    CorrectWindowBias(kCamera, {.variance = kVariance}, &map);
    for (int y = 12; y < kSize - 12; y += 3)
      for (int x = 12; x < kSize - 12; x += 3)
        ASSERT_NEAR(Off(map, x, y, Bent(x, y, kx, ky)), 0, 2e-3) << x << ' ' << y;
  }
}

TEST(WindowBias, PackedMapsBecomeTheSame) {
  stereo::PlaneMap map = MapOf([](int x, int y) { return x > 50 ? 0 : Bent(x, y, 0.03, 0.02); }),
                   packed = map;
  packed.Pack();
  CorrectWindowBias(kCamera, {.variance = kVariance}, &map),
      CorrectWindowBias(kCamera, {.variance = kVariance}, &packed);
  packed.Unpack();
  for (std::size_t i = 0; i < map.size(); ++i)
    ASSERT_EQ(map.InverseDepth(i), packed.InverseDepth(i));
}

TEST(WindowBias, SlantsStepsRimsAndDoubtfulPixelsStayAsTheyAre) {
  // A step of 20 pixels of depth at x = 32, between two slanted planes.
  auto step = [](int x, int y) { return Bent(x, y, 0, 0) + (x < 32 ? 0 : 20 * 0.5 / kCamera.fx); };
  stereo::PlaneMap map = MapOf(step);
  CorrectWindowBias(kCamera, {.variance = kVariance}, &map);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      ASSERT_NEAR(Off(map, x, y, step(x, y)), 0, 2e-3) << x << ' ' << y;
  // Curved: at the map's border, and among pixels with bad matches, the curvature is unknown.
  const stereo::PlaneMap bent = MapOf([](int x, int y) { return Bent(x, y, 0.03, 0.03); });
  stereo::PlaneMap doubtful = bent;
  for (std::size_t i = 0; i < doubtful.size(); ++i)
    if (i % 3) doubtful.SetExpectedError(i, 4);
  map = bent;
  CorrectWindowBias(kCamera, {.variance = kVariance}, &map),
      CorrectWindowBias(kCamera, {.variance = kVariance}, &doubtful);
  EXPECT_EQ(map.InverseDepth(1), bent.InverseDepth(1));
  EXPECT_NE(map.InverseDepth(30 * kSize + 30), bent.InverseDepth(30 * kSize + 30));
  for (std::size_t i = 1; i < doubtful.size(); i += 3)
    EXPECT_EQ(doubtful.InverseDepth(i), bent.InverseDepth(i));
}

TEST(WindowBias, ABumpSmallerThanTheWindowMovesByAtMostTwoPixelsAndNoVarianceChangesNothing) {
  const stereo::PlaneMap before = MapOf([](int x, int y) {
    return 0.5 + 0.001 * 30 * std::exp(-((x - 32) * (x - 32) + (y - 32) * (y - 32)) / 18.0);
  });
  stereo::PlaneMap map = before;
  CorrectWindowBias(kCamera, {.variance = 0}, &map);
  for (std::size_t i = 0; i < map.size(); ++i)
    ASSERT_EQ(map.InverseDepth(i), before.InverseDepth(i));
  CorrectWindowBias(kCamera, {.variance = 40}, &map);
  for (int y = 0; y < kSize; ++y)
    for (int x = 0; x < kSize; ++x)
      ASSERT_LE(
          std::abs(Off(map, x, y, before.InverseDepth(static_cast<std::size_t>(y) * kSize + x))),
          2.2)
          << x << ' ' << y;
}

}  // namespace keypose::reconstruct::window_bias_test
