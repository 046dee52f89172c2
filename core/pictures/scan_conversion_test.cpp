#include "core/pictures/scan_conversion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/pictures/fit_view.h"
#include "core/surfaces/shapes.h"

namespace keypose::scan_conversion_test {

constexpr int kWidth = 90, kHeight = 70;

/// n x n samples a pixel.
std::vector<Eigen::Vector2d> Grid(int n) {
  std::vector<Eigen::Vector2d> pattern;
  for (int s = 0; s < n * n; ++s) pattern.emplace_back((s % n + 0.5) / n, (s / n + 0.5) / n);
  return pattern;
}

/// By pixel and sample.
std::vector<RayScene::Hit> AllHits(const Mesh& mesh, const View& view, int n) {
  const auto scan = ScanConversion::Of(mesh.points, mesh.faces, view, Grid(n));
  std::vector<RayScene::Hit> hits;
  if (scan) scan->Fill({0, 0, kWidth, kHeight}, {}, hits);
  return hits;
}

/// A ball on a stick that leaves it at both ends: parts hide parts, and back faces are seen.
Mesh Tangle() {
  Mesh mesh = MakeIcosphere(3), stick = MakeCylinder(0.3, 4, 24, 20);
  stick.points.col(2).array() -= 1.2;
  stick.points.col(0) += 0.5 * stick.points.col(2);
  const Eigen::Index count = mesh.points.rows(), faces = mesh.faces.rows();
  mesh.points.conservativeResize(count + stick.points.rows(), 3);
  mesh.points.bottomRows(stick.points.rows()) = stick.points;
  mesh.faces.conservativeResize(faces + stick.faces.rows(), 3);
  mesh.faces.bottomRows(stick.faces.rows()) = stick.faces.array() + static_cast<int>(count);
  return mesh;
}

TEST(ScanConversion, SamplesHitWhatTheirRaysHit) {
  const Mesh mesh = Tangle();
  const RayScene scene(mesh.points, mesh.faces);
  for (const double azimuth : {0.0, 35.0, 110.0, 260.0}) {
    const View view = FitView(mesh.points, azimuth, 25, kWidth, kHeight);
    const Eigen::Matrix3d world_from_camera =
        view.camera_from_world.rotation.conjugate().toRotationMatrix();
    const int n = 2;
    const auto hits = AllHits(mesh, view, n);
    ASSERT_EQ(hits.size(), n * n * kWidth * kHeight);
    int hit = 0, different = 0;
    for (int i = 0; i < n * n * kWidth * kHeight; ++i) {
      const RayScene::Hit& here = hits[i];
      const int pixel = i / (n * n);
      const Eigen::Vector2d at =
          Eigen::Vector2d(pixel % kWidth, pixel / kWidth) + Grid(n)[i % (n * n)];
      const RayScene::Hit ray =
          scene.Cast(view.Center(), world_from_camera * view.camera.Unproject(at));
      hit += ray.face >= 0;
      // Rays are of single precision: at an edge they may choose the other side.
      if (here.face != ray.face) {
        ++different;
        continue;
      }
      if (here.face < 0) continue;
      EXPECT_NEAR(here.distance, ray.distance, 2e-5 * ray.distance);
      EXPECT_NEAR(here.u, ray.u, 2e-3);
      EXPECT_NEAR(here.v, ray.v, 2e-3);
    }
    EXPECT_GT(hit, 3000) << azimuth;
    EXPECT_LE(different, hit / 1000) << azimuth;
  }
}

// A sphere's outline is a convex curve: between the first and the last sample of a row that see it,
// there is none that sees past it. Many vertices and edges lie exactly on samples.
TEST(ScanConversion, ClosedSurfacesHaveNoHoles) {
  Mesh plane;  // 30 x 30 quads whose corners are at samples' centres
  plane.points.resize(31 * 31, 3);
  for (int j = 0; j <= 30; ++j)
    for (int i = 0; i <= 30; ++i) plane.points.row(31 * j + i) << i + 10.5, j + 10.5, 1;
  plane.faces.resize(2 * 30 * 30, 3);
  for (int j = 0; j < 30; ++j)
    for (int i = 0; i < 30; ++i) {
      const int a = 31 * j + i, b = a + 1, c = a + 31, d = c + 1;
      plane.faces.row(2 * (30 * j + i)) << a, b, d;
      plane.faces.row(2 * (30 * j + i) + 1) << a, d, c;
    }
  View view;
  view.camera = {kWidth, kHeight, 1, 1, 0, 0};
  const auto flat = AllHits(plane, view, 1);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x)
      EXPECT_EQ(flat[y * kWidth + x].face >= 0, x >= 10 && x <= 40 && y >= 10 && y <= 40);
  const Mesh sphere = MakeIcosphere(5);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(0, 360);
  for (int trial = 0; trial < 10; ++trial) {
    const auto hits = AllHits(
        sphere, FitView(sphere.points, angle(random), 0.2 * angle(random), kWidth, kHeight), 3);
    const auto seen = [&](int x, int y) {
      return hits[9 * ((y / 3) * kWidth + x / 3) + 3 * (y % 3) + x % 3].face >= 0;
    };
    for (int y = 0; y < 3 * kHeight; ++y) {
      int changes = 0;
      for (int x = 1; x < 3 * kWidth; ++x) changes += seen(x, y) != seen(x - 1, y);
      EXPECT_TRUE(changes == 0 || changes == 2) << trial << " " << y;
    }
  }
}

TEST(ScanConversion, APartOfThePictureIsThatPartOfTheWholeAndOnlyWhatIsWanted) {
  const Mesh mesh = Tangle();
  const View view = FitView(mesh.points, 20, 25, kWidth, kHeight);
  const auto all = AllHits(mesh, view, 1);
  const auto scan = ScanConversion::Of(mesh.points, mesh.faces, view, Grid(1));
  std::vector<RayScene::Hit> part;
  std::vector<int> places;
  int wanted = 0;
  for (int i = 0; i < (77 - 21) * (55 - 13); ++i) places.push_back(i % 3 != 0 ? wanted++ : -1);
  scan->Fill({21, 13, 77, 55}, places, part);
  ASSERT_EQ(part.size(), wanted);
  for (int y = 13; y < 55; ++y)
    for (int x = 21; x < 77; ++x) {
      const int at = (y - 13) * (77 - 21) + x - 21;
      if (places[at] < 0) continue;
      const RayScene::Hit &a = part[places[at]], &b = all[y * kWidth + x];
      EXPECT_TRUE(a.face == b.face && a.distance == b.distance && a.u == b.u && a.v == b.v);
    }
}

TEST(ScanConversion, FacesWithoutAreaGiveNoHitThatIsNotInThem) {
  Mesh mesh;  // needles through the centres of samples, level, upright and oblique; and a point
  mesh.points.resize(9, 3);
  mesh.points << 10.5, 10.5, 1, 60.5, 10.5, 1, 35.5, 10.5 + 1e-15, 1,  //
      20.5, 5.5, 1, 20.5, 60.5, 1, 20.5, 30.5, 1,                      //
      5.5, 5.5, 1, 55.5, 55.5, 1, 30.5, 30.5 + 4e-15, 1;
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0;
  View view;
  view.camera = {kWidth, kHeight, 1, 1, 0, 0};
  for (const RayScene::Hit& hit : AllHits(mesh, view, 3)) {
    if (hit.face < 0) continue;
    EXPECT_NEAR(hit.distance, 1, 1e-9);
    EXPECT_TRUE(hit.u >= 0 && hit.v >= 0 && hit.u + hit.v <= 1 + 1e-12) << hit.u << " " << hit.v;
  }
}

TEST(ScanConversion, LeavesToRaysWhatItCannotProject) {
  const Mesh mesh = MakeIcosphere(2);
  const View view = FitView(mesh.points, 20, 25, kWidth, kHeight);
  EXPECT_TRUE(ScanConversion::Of(mesh.points, mesh.faces, view, Grid(1)));
  View distorted = view;
  distorted.camera.k1 = 0.01;
  EXPECT_FALSE(ScanConversion::Of(mesh.points, mesh.faces, distorted, Grid(1)));
  View inside = view;
  inside.camera_from_world.translation.setZero();
  EXPECT_FALSE(ScanConversion::Of(mesh.points, mesh.faces, inside, Grid(1)));
  PointsX3 broken = mesh.points;
  broken(3, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(ScanConversion::Of(broken, mesh.faces, view, Grid(1)));
}

}  // namespace keypose::scan_conversion_test
