#include "reconstruct/outline_evidence.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/render.h"
#include "reconstruct/rim_points.h"
#include "reconstruct/visual_hull.h"

namespace keypose::reconstruct {
namespace {

constexpr int kSize = 160;

// Two rings of cameras around a unit ball, with the ball's exact masks.
std::vector<DenseView> ViewsOfABall() {
  std::vector<DenseView> views;
  for (int i = 0; i < 24; ++i) {
    const double azimuth = 2 * M_PI * i / 12 + (i / 12) * 0.26, elevation = (i < 12 ? 15 : 45) * M_PI / 180;
    View view;
    view.name = "v" + std::to_string(i);
    view.camera = {.width = kSize, .height = kSize, .fx = 300, .fy = 300, .cx = kSize / 2.0, .cy = kSize / 2.0};
    view.camera_from_world =
        LookAt(5 * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation), std::sin(elevation)),
               Eigen::Vector3d::Zero());
    Image8 mask(kSize, kSize, 1);
    const Eigen::Vector3d middle = view.camera_from_world * Eigen::Vector3d::Zero();
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        const Eigen::Vector3d ray = view.camera.Unproject({x + 0.5, y + 0.5}).normalized();
        if (middle.cross(ray).norm() < 1) *mask.at(x, y) = 255;
      }
    views.push_back(PrepareDenseView(view, i, Image8(kSize, kSize, 3, 90), mask, 1.0, 3));
  }
  return views;
}

struct Ball {
  std::vector<DenseView> views = ViewsOfABall();
  VisualHull hull = CarveVisualHull(views, {.resolution = 96, .outside_votes = 1});
  Silhouettes silhouettes{views, 1};
  double footprint = MiddleFootprint(hull, silhouettes);
  // As if the ball were a part of a figure six times as large: so few views leave long pieces of rays.
  double extent = 12;
  PointCloud rims = RimPoints(hull, silhouettes, views, {.sure_length = 0.2, .longest_length = 0.3});
};
const Ball& TheBall() {
  static const Ball ball;
  return ball;
}

// Points of the upper half of a ball of another radius.
PointCloud Shell(double radius, float confidence) {
  PointCloud cloud;
  const int count = 20000;
  cloud.points.resize(count, 3), cloud.normals.resize(count, 3), cloud.colors.setZero(count, 3);
  cloud.confidence.setConstant(count, confidence);
  for (int i = 0; i < count; ++i) {
    const double z = (i + 0.5) / count, angle = i * 2.399963229728653;  // a Fibonacci spiral
    const Eigen::Vector3d n(std::sqrt(1 - z * z) * std::cos(angle), std::sqrt(1 - z * z) * std::sin(angle), z);
    cloud.points.row(i) = radius * n, cloud.normals.row(i) = n;
  }
  return cloud;
}

double MedianMiss(const PointCloud& cloud, double footprint) {
  std::vector<double> misses;
  for (Eigen::Index i = 0; i < cloud.points.rows(); ++i) misses.push_back(std::abs(cloud.points.row(i).norm() - 1) / footprint);
  std::nth_element(misses.begin(), misses.begin() + static_cast<std::ptrdiff_t>(misses.size() / 2), misses.end());
  return misses[misses.size() / 2];
}

OutlineEvidence Hear(PointCloud cloud) {
  const Ball& ball = TheBall();
  return HearOutlines(std::move(cloud), ball.rims, ball.silhouettes, ball.footprint, ball.extent, {});
}

TEST(RimPoints, LieOnTheBallWithItsNormals) {
  const Ball& ball = TheBall();
  ASSERT_GT(ball.rims.points.rows(), 500);
  double worst = 0, least_cosine = 1;
  for (Eigen::Index i = 0; i < ball.rims.points.rows(); ++i) {
    worst = std::max(worst, std::abs(ball.rims.points.row(i).norm() - 1) / ball.footprint);
    least_cosine = std::min(least_cosine, ball.rims.points.row(i).normalized().dot(ball.rims.normals.row(i)));
  }
  EXPECT_LT(worst, 1.5) << "footprints; a mask's rim is known to half a pixel";
  EXPECT_LT(MedianMiss(ball.rims, ball.footprint), 0.5);
  EXPECT_GT(least_cosine, 0.9);
}

TEST(HearOutlines, PatchBehindTheSurfaceIsPutOnIt) {
  const Ball& ball = TheBall();
  PointCloud cloud = Shell(1, 0.9f);
  int behind = 0;
  for (Eigen::Index i = 0; i < cloud.points.rows(); ++i)
    if (cloud.normals(i, 0) > 0.7) cloud.points.row(i) *= 1 - 8 * ball.footprint, ++behind;  // as a lamp's image in something glossy
  const OutlineEvidence evidence = Hear(cloud);
  EXPECT_GT(evidence.contradicted, behind * 2 / 3);
  int still = 0;
  for (Eigen::Index i = 0; i < evidence.cloud.points.rows(); ++i) still += evidence.cloud.points.row(i).norm() < 1 - 4 * ball.footprint;
  EXPECT_LT(still, behind / 4);
}

TEST(HearOutlines, DepthsThatAllErrAreMovedToTheOutlines) {
  const Ball& ball = TheBall();
  const OutlineEvidence evidence = Hear(Shell(1 - 4 * ball.footprint, 0.9f));
  EXPECT_GT(evidence.errors[kErrorClasses - 1], 3);
  EXPECT_LT(MedianMiss(evidence.cloud, ball.footprint), 1.2) << "they were 4 footprints behind";
}

TEST(HearOutlines, ExactDepthsStayWhereTheyAre) {
  const PointCloud exact = Shell(1, 0.9f);
  const OutlineEvidence evidence = Hear(exact);
  EXPECT_EQ(evidence.contradicted + evidence.dropped, 0);
  ASSERT_EQ(evidence.cloud.points.rows(), exact.points.rows());
  EXPECT_LT((evidence.cloud.points - exact.points).rowwise().norm().maxCoeff(), 0.7 * TheBall().footprint);
  EXPECT_LT(MedianMiss(evidence.cloud, TheBall().footprint), 0.2);
}

TEST(HearOutlines, NothingToHearChangesNothing) {
  const Ball& ball = TheBall();
  const PointCloud cloud = Shell(0.9, 0.5f);
  const OutlineEvidence alone = HearOutlines(cloud, {}, ball.silhouettes, ball.footprint, ball.extent, {});
  EXPECT_TRUE((alone.cloud.points.array() == cloud.points.array()).all());
  EXPECT_EQ(Hear({}).cloud.points.rows(), 0);
}

}  // namespace
}  // namespace keypose::reconstruct
