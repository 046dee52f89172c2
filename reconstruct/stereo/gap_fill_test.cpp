#include "reconstruct/stereo/gap_fill.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "reconstruct/testing/rendered_ring.h"

namespace keypose::reconstruct::gap_fill_test {

using testing::AllOthers;

constexpr int kSize = 120;
constexpr double kFocal = 300, kDistance = 4;

// Cameras ten degrees apart, directed at the origin; all pixels are object.
std::vector<PreparedView> Views(int count) {
  std::vector<PreparedView> views;
  for (int i = 0; i < count; ++i) {
    const double azimuth = 10 * i * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera = {.width = kSize,
                   .height = kSize,
                   .fx = kFocal,
                   .fy = kFocal,
                   .cx = kSize / 2.0,
                   .cy = kSize / 2.0};
    view.camera_from_world =
        LookAt(kDistance * Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 1.5).normalized(),
               Eigen::Vector3d::Zero());
    views.push_back(
        PrepareView(view, i, Image8(kSize, kSize, 3, 90), Image8(kSize, kSize, 1, 255), 1.0, 1));
  }
  return views;
}

// Intersection of a camera's ray with the ball of radius 2 below the origin, or with the plane z =
// 0: depth over the ray.
using Surface = std::function<double(const Eigen::Vector3d& from, const Eigen::Vector3d& ray)>;
double Plane(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  return -from.z() / ray.z();
}
double Ball(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const Eigen::Vector3d c = from - Eigen::Vector3d(0, 0, -2);
  const double a = ray.squaredNorm(), b = c.dot(ray), d = b * b - a * (c.squaredNorm() - 4);
  return d > 0 ? (-b - std::sqrt(d)) / a : 0;
}

bool WithinHole(const Eigen::Vector3d& x, double radius) { return x.norm() < radius; }

// Cells of the surface, without those in the hole around the origin.
std::vector<SurfaceCells> Cells(const std::vector<PreparedView>& views, const Surface& surface,
                                double hole) {
  std::vector<SurfaceCells> all;
  for (const PreparedView& view : views) {
    SurfaceCells cells{kSize / kCellPixels, kSize / kCellPixels, {}};
    for (int y = 0; y < cells.height; ++y)
      for (int x = 0; x < cells.width; ++x) {
        const Eigen::Vector3d ray = view.camera_from_world.rotation.conjugate() *
                                    view.camera().Ray(kCellPixels * x + 1.5, kCellPixels * y + 1.5);
        const double depth = surface(view.Center(), ray);
        const bool gap = depth > 0 && WithinHole(view.Center() + depth * ray, hole);
        cells.inverse_depth.push_back(depth <= 0 ? -1.0f
                                      : gap      ? 0.0f
                                                 : static_cast<float>(1 / depth));
      }
    all.push_back(cells);
  }
  return all;
}

TEST(FillGaps, HoleInAPlaneGetsThePlaneOnce) {
  const std::vector<PreparedView> views = Views(4);
  const PointCloud cloud = FillGaps(views, AllOthers(4), Cells(views, Plane, 0.2), {});
  // The hole is 30 pixels wide, seen at 34 degrees from above: about 35 cells of 4 x 4.
  ASSERT_GT(cloud.points.rows(), 20);
  EXPECT_LT(cloud.points.rows(), 70) << "views of one gap are merged, not stacked";
  EXPECT_LT(cloud.points.col(2).cwiseAbs().maxCoeff(), 1e-5);
  EXPECT_GT(cloud.normals.col(2).minCoeff(), 1 - 1e-4);
  EXPECT_LT(cloud.points.rowwise().norm().maxCoeff(), 0.25);
  EXPECT_TRUE((cloud.confidence.array() == kGapConfidence).all());
}

TEST(FillGaps, HoleInABallIsBridgedRound) {
  const std::vector<PreparedView> views = Views(4);
  const PointCloud cloud = FillGaps(views, AllOthers(4), Cells(views, Ball, 0.18), {});
  ASSERT_GT(cloud.points.rows(), 15);
  const Eigen::VectorXd radius =
      (cloud.points.rowwise() - Eigen::RowVector3d(0, 0, -2)).rowwise().norm();
  // A pixel is 4 / 300 there; the error of a plane over the hole would be a quarter of 0.18
  // squared, 0.6 pixels.
  EXPECT_LT((radius.array() - 2).abs().maxCoeff(), 0.35 * kDistance / kFocal);
  const PointsX3 outward =
      (cloud.points.rowwise() - Eigen::RowVector3d(0, 0, -2)).rowwise().normalized();
  EXPECT_GT((outward.array() * cloud.normals.array()).rowwise().sum().minCoeff(), 0.99);
}

TEST(FillGaps, EdgesOpenBordersAndWideGapsStayOpen) {
  const std::vector<PreparedView> views = Views(4);
  // Half of the surroundings are 15 pixels above the others.
  const Surface step = [](const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const double low = Plane(from, ray), high = (0.2 - from.z()) / ray.z();
    return (from + high * ray).y() > 0 ? high : low;
  };
  EXPECT_EQ(FillGaps(views, AllOthers(4), Cells(views, step, 0.12), {}).points.rows(), 0);
  const Surface half = [](const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    const double depth = Plane(from, ray);
    return (from + depth * ray).y() > 0 ? 0 : depth;
  };
  const PointCloud open = FillGaps(views, AllOthers(4), Cells(views, half, 0.2), {});
  for (Eigen::Index i = 0; i < open.points.rows(); ++i)
    EXPECT_LT(open.points(i, 1), -0.04) << "what has depths on one side only";
  const PointCloud wide = FillGaps(views, AllOthers(4), Cells(views, Plane, 0.6), {});
  for (Eigen::Index i = 0; i < wide.points.rows(); ++i)
    EXPECT_GT(wide.points.row(i).norm(), 0.4) << "24 pixels are the reach";
}

TEST(FillGaps, ViewsThatSeeBehindItOrDoNotAgreeForbidIt) {
  const std::vector<PreparedView> views = Views(4);
  std::vector<SurfaceCells> cells = Cells(views, Plane, 0.15);
  const Surface below = [](const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
    return (-0.3 - from.z()) / ray.z();
  };
  cells[2] = Cells(views, below, 0)[2];
  EXPECT_EQ(FillGaps(views, AllOthers(4), cells, {}).points.rows(), 0);
  EXPECT_EQ(
      FillGaps(views, AllOthers(4), Cells(views, Plane, 0.15), {.least_views = 5}).points.rows(),
      0);
}

TEST(FillGaps, SameBitsForAnyThreadCount) {
  const std::vector<PreparedView> views = Views(4);
  SetThreadCount(1);
  const PointCloud one = FillGaps(views, AllOthers(4), Cells(views, Ball, 0.15), {});
  SetThreadCount(3);
  const PointCloud three = FillGaps(views, AllOthers(4), Cells(views, Ball, 0.15), {});
  SetThreadCount(0);
  ASSERT_GT(one.points.rows(), 10);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.normals, three.normals);
}

TEST(CellsOf, TakeConfirmedPixelsAndTellGapsFromTheRim) {
  std::vector<PreparedView> views = Views(1);
  GreyMask& grey = views[0].levels[0].grey;
  for (int x = 0; x < 4; ++x) *grey.at(x, 0) &= static_cast<std::uint16_t>(~1u);
  stereo::PlaneMap map(views[0].camera(), 2);
  std::vector<char> confirmed(map.size(), 0);
  for (int y = 4; y < 8; ++y)
    for (int x = 4; x < 6; ++x) {
      const std::size_t pixel = static_cast<std::size_t>(y) * kSize + x;
      map.SetPlane(pixel, {0.25f + 0.001f * static_cast<float>(x), 0.001f, 0});
      confirmed[pixel] = 1;
    }
  const SurfaceCells cells = CellsOf(views[0], map, confirmed);
  ASSERT_EQ(cells.width, kSize / kCellPixels);
  EXPECT_LT(cells.At(0, 0), 0) << "its first row is not in the mask";
  EXPECT_EQ(cells.At(2, 0), 0);
  EXPECT_NEAR(cells.At(1, 1), 0.25 + 0.001 * 5.5, 2e-6);
}

}  // namespace keypose::reconstruct::gap_fill_test
