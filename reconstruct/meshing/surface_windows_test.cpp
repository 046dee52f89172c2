// A plate with a window that is covered by wrong points, and photographs that see through it.
#include "reconstruct/meshing/surface_windows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"
#include "reconstruct/meshing/surface.h"

namespace keypose::reconstruct::windows_test {

using Eigen::Vector3d;

constexpr double kHalf = 1, kThick = 0.15, kWindow = 0.35, kSpacing = 0.04,
                 kPixel = 0.01;  // size of a pixel at the plate

/// Both sides and the edge of the plate, with points of low confidence in the window as well, as
/// from the hull of masks that closed it.
PointCloud WebbedPlate() {
  std::vector<Vector3d> points, normals;
  std::vector<float> sure;
  const auto add = [&](const Vector3d& x, const Vector3d& n, float confidence) {
    points.push_back(x), normals.push_back(n), sure.push_back(confidence);
  };
  for (double y = -kHalf; y <= kHalf; y += kSpacing)
    for (double z = -kHalf; z <= kHalf; z += kSpacing) {
      const float confidence = std::max(std::abs(y), std::abs(z)) < kWindow ? 0.2F : 1.0F;
      for (const double side : {-1.0, 1.0}) add({side * kThick, y, z}, {side, 0, 0}, confidence);
    }
  for (double x = -kThick; x <= kThick; x += kSpacing)
    for (double t = -kHalf; t <= kHalf; t += kSpacing)
      for (const double side : {-1.0, 1.0}) {
        add({x, side * kHalf, t}, {0, side, 0}, 1);
        add({x, t, side * kHalf}, {0, 0, side}, 1);
      }
  PointCloud cloud;
  cloud.points.resize(SizeOf(points), 3);
  cloud.normals.resize(SizeOf(points), 3);
  cloud.confidence.resize(SizeOf(points));
  for (int i = 0; i < std::ssize(points); ++i) {
    cloud.points.row(i) = points[i];
    cloud.normals.row(i) = normals[i];
    cloud.confidence[i] = sure[i];
  }
  return cloud;
}

/// The exact outlines: in the window, or beyond the plate.
double Outside(const Vector3d& x) {
  const double across = std::max(std::abs(x.y()), std::abs(x.z()));
  return std::max(kWindow - across, std::max(across - kHalf, std::abs(x.x()) - kThick)) / kPixel;
}

std::vector<SightLine> LinesOf(int views) {
  std::vector<SightLine> lines;
  for (int v = 0; v < views; ++v)
    for (const double y : {-0.1, 0.0, 0.1}) {
      const Vector3d from(v % 2 ? 4 : -4, 0.5 * (v / 2), 0);
      lines.push_back({from, Vector3d(0, y, 0.1) - from, v, v});
    }
  return lines;
}

SurfaceResult Fit(int views) {
  MeshOptions options;
  options.depth = 6;
  options.filter.thin_unsure = false;
  return ReconstructSurface(WebbedPlate(), options, "plate.ply", nullptr,
                            {LinesOf(views), [] { return OutsideField(Outside); }});
}

const SurfaceResult& Webbed() {
  static const SurfaceResult webbed = Fit(0);
  return webbed;
}

int GenusOf(const Mesh& mesh) { return 1 - CheckClosed(mesh).euler / 2; }

TEST(Windows, StayOpenWherePhotographsSeeThrough) {
  const SurfaceResult &webbed = Webbed(), open = Fit(4);
  ASSERT_TRUE(CheckClosed(webbed.mesh).closed());
  EXPECT_EQ(GenusOf(webbed.mesh), 0);
  EXPECT_EQ(webbed.window_points, 0);
  ASSERT_TRUE(CheckClosed(open.mesh).closed());
  EXPECT_EQ(GenusOf(open.mesh), 1);
  EXPECT_EQ(open.views_with_closed_window, 4);
  EXPECT_GT(open.window_points, 100);
  // As wide as in the outlines, up to a finest cell: 2.5 / 64.
  double narrowest = kHalf;
  for (int v = 0; v < open.mesh.vertex_count(); ++v)
    if (std::abs(open.mesh.points(v, 0)) < kThick / 2)
      narrowest = std::min(
          narrowest, std::max(std::abs(open.mesh.points(v, 1)), std::abs(open.mesh.points(v, 2))));
  EXPECT_NEAR(narrowest, kWindow, 0.04);
}

TEST(Windows, TwoViewsAreNotBelieved) { EXPECT_EQ(Fit(2).window_points, 0); }

TEST(Windows, WallsFaceTheWindow) {
  FilteredPoints points;
  points.cloud = WebbedPlate();
  points.spacing = Eigen::VectorXd::Constant(points.cloud.points.rows(), kSpacing);
  points.weights = points.cloud.confidence;
  points.median_spacing = kSpacing;
  const auto before = points.cloud.points.rows();
  const int walls = AddWindowWalls(Webbed().mesh, LinesOf(4), Outside, 0.04, &points);
  ASSERT_GT(walls, 100);
  EXPECT_LT(points.cloud.points.rows() - walls, before);  // the wrong points were removed
  for (Eigen::Index i = points.cloud.points.rows() - walls; i < points.cloud.points.rows(); ++i) {
    const Vector3d x = points.cloud.points.row(i), n = points.cloud.normals.row(i);
    if (std::abs(x.x()) > kThick - 0.04) continue;  // the plate's own faces beside the window
    EXPECT_NEAR(std::max(std::abs(x.y()), std::abs(x.z())), kWindow, 1e-6);
    EXPECT_LT(n.dot(Vector3d(0, x.y(), x.z())), 0);
  }
}

}  // namespace keypose::reconstruct::windows_test
