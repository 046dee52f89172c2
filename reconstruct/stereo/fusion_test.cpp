#include "reconstruct/stereo/fusion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/pictures/render.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::fusion_test {

using testing::AllOthers;

constexpr int kSize = 40;

// Cameras above the plane z = 0, ten degrees apart, all directed at the origin.
std::vector<PreparedView> ViewsOfThePlane(int count) {
  std::vector<PreparedView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 10 * i * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera = {.width = kSize, .height = kSize, .fx = 100, .fy = 100, .cx = 20, .cy = 20};
    view.camera_from_world =
        LookAt(4 * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 1.5).normalized(),
               Eigen::Vector3d::Zero());
    views.push_back(
        PrepareView(view, i, Image8(kSize, kSize, 3, 90), Image8(kSize, kSize, 1, 255), 1.0, 1));
  }
  return views;
}

// The exact map of the plane z = height.
stereo::PlaneMap MapOf(const PreparedView& view, double height) {
  const Pinhole& camera = view.camera();
  const Eigen::Vector3d normal = view.camera_from_world.rotation * Eigen::Vector3d::UnitZ();
  const double offset = normal.dot(
      view.camera_from_world * Eigen::Vector3d(0, 0, height));  // normal . x = offset in the camera
  stereo::PlaneMap map(camera, 8);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * camera.width + x;
      map.SetPlane(i, {static_cast<float>(normal.dot(camera.Ray(x, y)) / offset),
                       static_cast<float>(normal.x() / camera.fx / offset),
                       static_cast<float>(normal.y() / camera.fy / offset)});
      map.SetCost(i, 0.1f);
    }
  return map;
}

TEST(PlaneMap, UnpacksToWhatWasPacked) {
  for (const int source_count : {8, 12}) {
    stereo::PlaneMap map(ViewsOfThePlane(1)[0].camera(), source_count);
    for (std::size_t i = 0; i < map.size(); i += 3) {
      map.SetPlane(i, {0.2f + 1e-5f * static_cast<float>(i), 1e-4f, -2e-4f});
      map.SetCost(i, 0.001f * static_cast<float>(i % 900)),
          map.SetMatch(i, {0.002f * static_cast<float>(i % 500), 0.01f});
      map.SetSources(i, static_cast<std::uint16_t>(source_count > 8 ? i % 4096 : i % 256));
    }
    const stereo::PlaneMap before = map;
    map.Pack();
    std::size_t planes = 0;
    map.ForEachPlane([&](std::size_t pixel, std::size_t place) {
      EXPECT_EQ(map.Find(pixel), place);
      EXPECT_EQ(map.InverseDepth(place), before.InverseDepth(pixel));
      ++planes;
    });
    EXPECT_EQ(planes, (before.size() + 2) / 3);
    EXPECT_EQ(map.Find(1), stereo::PlaneMap::kNone);
    EXPECT_EQ(before.Find(1), stereo::PlaneMap::kNone);
    EXPECT_EQ(before.Find(3), 3u);
    map.Unpack();
    ASSERT_EQ(map.size(), before.size());
    for (std::size_t i = 0; i < map.size(); ++i) {
      ASSERT_EQ(map.InverseDepth(i), before.InverseDepth(i));
      ASSERT_EQ(map.Plane(i).gx, before.Plane(i).gx);
      ASSERT_EQ(map.PackedCost(i), before.PackedCost(i));
      ASSERT_EQ(map.MatchOf(i).all, before.MatchOf(i).all);
      ASSERT_EQ(map.MatchOf(i).pair, before.MatchOf(i).pair);
      ASSERT_EQ(map.Sources(i), before.Sources(i));
    }
  }
}

TEST(PlaneMap, WithoutAnyPlanePacksAndUnpacksToNone) {
  stereo::PlaneMap map(ViewsOfThePlane(1)[0].camera(), 8);
  map.Pack(), map.Unpack();
  ASSERT_EQ(map.size(), static_cast<std::size_t>(kSize) * kSize);
  EXPECT_EQ(map.InverseDepth(kSize), 0);
  EXPECT_EQ(map.PackedCost(kSize), stereo::PlaneMap::kNoCost);
}

TEST(FuseDepthMaps, ExactMapsOfAPlaneGiveThePlane) {
  const std::vector<PreparedView> views = ViewsOfThePlane(4);
  std::vector<stereo::PlaneMap> maps;
  for (const PreparedView& view : views) maps.push_back(MapOf(view, 0));
  const FusionResult fused = FuseDepthMaps(views, AllOthers(4), maps, {});
  ASSERT_GT(fused.cloud.points.rows(), kSize * kSize / 2);
  EXPECT_LT(fused.cloud.points.rows(), 3 * kSize * kSize)
      << "views of one surface are merged, not stacked";
  EXPECT_LT(fused.cloud.points.col(2).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_GT(fused.cloud.normals.col(2).minCoeff(), 1 - 1e-5);
  EXPECT_GT(*std::min_element(fused.completeness.begin(), fused.completeness.end()), 0.7);
  EXPECT_GT(fused.cloud.confidence.maxCoeff(), 0.6f);
}

TEST(FuseDepthMaps, MapThatNoOtherConfirmsAddsNothing) {
  const std::vector<PreparedView> views = ViewsOfThePlane(4);
  std::vector<stereo::PlaneMap> maps;
  for (int i = 0; i < 4; ++i) maps.push_back(MapOf(views[i], i == 2 ? 0.15 : 0));
  const FusionResult fused = FuseDepthMaps(views, AllOthers(4), maps, {});
  EXPECT_EQ(std::count(fused.confirmed[2].begin(), fused.confirmed[2].end(), 1), 0);
  ASSERT_GT(fused.cloud.points.rows(), kSize * kSize / 2);
  EXPECT_LT(fused.cloud.points.col(2).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(FuseDepthMaps, DepthsThatAreExpectedToErrGiveNothing) {
  const std::vector<PreparedView> views = ViewsOfThePlane(4);
  std::vector<stereo::PlaneMap> maps;
  for (const PreparedView& view : views) {
    maps.push_back(MapOf(view, 0));
    for (std::size_t i = 0; i < maps.back().size(); ++i)
      maps.back().SetExpectedError(i, i % kSize < kSize / 2 ? 0.3f : 1.5f);
  }
  EXPECT_NEAR(maps[0].ExpectedError(0), 0.3f, 0.3f * 0.03f);
  EXPECT_NEAR(maps[0].ExpectedError(kSize - 1), 1.5f, 1.5f * 0.03f);
  const FusionResult fused = FuseDepthMaps(views, AllOthers(4), maps, {});
  ASSERT_GT(fused.cloud.points.rows(), 0);
  for (const std::vector<char>& confirmed : fused.confirmed)
    for (std::size_t i = 0; i < confirmed.size(); ++i)
      ASSERT_FALSE(confirmed[i] && i % kSize >= kSize / 2);
  FusionOptions all;
  all.largest_error = 2;
  EXPECT_GT(FuseDepthMaps(views, AllOthers(4), maps, all).cloud.points.rows(),
            fused.cloud.points.rows() * 3 / 2);
}

TEST(FuseDepthMaps, TooFewViewsOrTooPoorMatchesGiveNothing) {
  const std::vector<PreparedView> views = ViewsOfThePlane(4);
  std::vector<stereo::PlaneMap> maps;
  for (const PreparedView& view : views) maps.push_back(MapOf(view, 0));
  FusionOptions options;
  options.least_views = 5;
  EXPECT_EQ(FuseDepthMaps(views, AllOthers(4), maps, options).cloud.points.rows(), 0);
  options = {};
  options.largest_cost = 0.05;
  EXPECT_EQ(FuseDepthMaps(views, AllOthers(4), maps, options).cloud.points.rows(), 0);
}

}  // namespace keypose::reconstruct::fusion_test
