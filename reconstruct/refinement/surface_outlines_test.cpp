#include "reconstruct/refinement/surface_outlines.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/numbers/parallel.h"
#include "core/numbers/statistics.h"
#include "core/pictures/render.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct::outlines_test {

constexpr int kSize = 300;
constexpr double kFocal = 700;
constexpr double kDistance = 7;
constexpr double kPixel =
    // size of a pixel at the middle, in world units: the unit ball is 100 pixels wide
    kDistance / kFocal;

View RingView(int i, int count, double elevation) {
  const double azimuth = 2 * M_PI * i / count;
  View view;
  view.name = "v" + std::to_string(i);
  view.camera = {
      .width = kSize, .height = kSize, .fx = kFocal, .fy = kFocal, .cx = 151.3, .cy = 148.6};
  view.camera_from_world = LookAt(
      kDistance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                  std::sin(azimuth) * std::cos(elevation), std::sin(elevation)),
      Eigen::Vector3d::Zero());
  return view;
}

// Three rings of twelve cameras with exact masks of the mesh; `spoil` may change a mask.
std::vector<PreparedView> Views(const Mesh& truth,
                                const std::function<void(int, Image8*)>& spoil = {}) {
  const RayScene scene(truth.points, truth.faces);
  std::vector<PreparedView> views;
  for (int i = 0; i < 36; ++i) {
    const View view = RingView(i % 12 * 3 + i / 12, 36, (-10 + 25 * (i / 12)) * M_PI / 180);
    const Raster raster = Rasterize(truth, scene, view);
    Image8 mask(kSize, kSize, 1);
    for (std::size_t k = 0; k < mask.data.size(); ++k)
      mask.data[k] = raster.face.data[k] >= 0 ? 255 : 0;
    if (spoil) spoil(i, &mask);
    views.push_back(PrepareView(view, i, Image8(kSize, kSize, 3, 90), mask, 1.0, 2));
  }
  return views;
}

Mesh Ball(int levels, double radius, double bumps) {
  Mesh mesh = MakeIcosphere(levels);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::Vector3d n = mesh.points.row(v);
    mesh.points.row(v) =
        (radius + bumps * std::sin(5 * n.x()) * std::cos(4 * n.y() + 1) * std::sin(5 * n.z() + 2)) *
        n;
  }
  return mesh;
}

struct Miss {
  double mean_px = 0, median_px = 0, p95_px = 0;
  int vertices = 0;  // with weight
};
// Distance from the truth of vertices that have a target, after moving to it.
Miss MissOf(const Mesh& mesh, const SurfaceTargets& targets, const Mesh& truth) {
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  const RayScene scene(truth.points, truth.faces);
  std::vector<double> misses;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if (targets.weight[v] < 0.2f) continue;
    const Eigen::Vector3d moved = mesh.points.row(v) + targets.offset[v] * normals.row(v);
    misses.push_back(std::sqrt(scene.ClosestPoint(moved).squared_distance) / kPixel);
  }
  Miss miss;
  miss.vertices = SizeOf(misses);
  if (misses.empty()) return miss;
  std::sort(misses.begin(), misses.end());
  for (const double m : misses) miss.mean_px += m / static_cast<double>(misses.size());
  miss.median_px = UpperMedian(misses), miss.p95_px = QuantileAbove(misses, 0.95);
  return miss;
}

Mesh Shifted(const Mesh& mesh, double pixels) {
  Mesh out = mesh;
  out.points += pixels * kPixel * VertexNormals(mesh.points, mesh.faces);
  return out;
}

TEST(OutlineTargets, PutASphereOfWrongRadiusOnTheTruth) {
  const Mesh truth = Ball(5, 1, 0);
  const Silhouettes silhouettes(Views(truth), 1);
  for (const double wrong : {-4.0, 0.0, 3.0}) {
    const Mesh mesh = Shifted(Ball(4, 1, 0), wrong);
    const SurfaceTargets targets = OutlineTargets(mesh, silhouettes);
    const Miss miss = MissOf(mesh, targets, truth);
    EXPECT_GT(miss.vertices, mesh.vertex_count() / 2) << wrong;
    EXPECT_LT(miss.mean_px, 0.2) << wrong;
    EXPECT_LT(miss.p95_px, 0.45) << wrong;
    EXPECT_NEAR(targets.gap_px, -wrong, 0.25);
  }
}

TEST(OutlineTargets, PutABumpySphereOnTheTruth) {
  const Mesh truth = Ball(5, 1, 0.08);
  const Silhouettes silhouettes(Views(truth), 1);
  for (const double wrong : {-2.0, 2.0}) {
    const Mesh mesh = Shifted(truth, wrong);
    const Miss miss = MissOf(mesh, OutlineTargets(mesh, silhouettes), truth);
    EXPECT_GT(miss.vertices, mesh.vertex_count() / 3) << wrong;
    EXPECT_LT(miss.mean_px, 0.2) << wrong;
    EXPECT_LT(miss.p95_px, 0.6) << wrong;
  }
}

TEST(OutlineTargets, WrongMasksDoNotPull) {
  const Mesh truth = Ball(5, 1, 0.08);
  const auto spoil = [](int i, Image8* mask) {
    for (int y = 0; y < kSize; ++y)
      for (int x = 0; x < kSize; ++x) {
        if (i == 5 && x < 90) *mask->at(x, y) = 0;  // a part is missing
        if (i == 14 && std::hypot(x - 170, y - 60) < 20)
          *mask->at(x, y) = 0;  // a bite out of the outline
        if (i == 20 && std::hypot(x - 150, y - 150) < 30) *mask->at(x, y) = 0;  // a hole
        if (i == 30 && std::hypot(x - 150, y - 150) < 106)
          *mask->at(x, y) = 255;  // grown all round
      }
  };
  const Silhouettes silhouettes(Views(truth, spoil), 2);
  const Mesh mesh = Shifted(truth, 1);
  const Miss miss = MissOf(mesh, OutlineTargets(mesh, silhouettes), truth);
  EXPECT_GT(miss.vertices, mesh.vertex_count() / 3);
  EXPECT_LT(miss.mean_px, 0.25);
  EXPECT_LT(miss.p95_px, 0.8);
}

// The mesh with a smooth dent (negative: a bump) of the given pixels around a direction, `width` of
// the radius wide.
Mesh Dented(Mesh mesh, const Eigen::Vector3d& direction, double width, double pixels) {
  const PointsX3 normals = VertexNormals(mesh.points, mesh.faces);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const double away =
        (Eigen::Vector3d(mesh.points.row(v)).normalized() - direction).norm() / width;
    mesh.points.row(v) -= pixels * kPixel * std::exp(-0.5 * away * away) * normals.row(v);
  }
  return mesh;
}

std::vector<FrontierPoint> FrontierPointsOf(const std::vector<PreparedView>& views,
                                            const Silhouettes& silhouettes) {
  return FindFrontierPoints(CarveVisualHull(views, {.resolution = 100, .outside_votes = 1}),
                            silhouettes, views, {.sure_length = 0.1, .longest_length = 0.3});
}

TEST(FindFrontierPoints, LieOnTheSurface) {
  const Mesh truth = Ball(5, 1, 0.08);
  const std::vector<PreparedView> views = Views(truth);
  const Silhouettes silhouettes(views, 1);
  const std::vector<FrontierPoint> frontier = FrontierPointsOf(views, silhouettes);
  ASSERT_GT(frontier.size(), 2000u);
  const RayScene scene(truth.points, truth.faces);
  std::vector<double> misses;
  for (const FrontierPoint& touch : frontier) {
    misses.push_back(std::sqrt(scene.ClosestPoint(touch.point).squared_distance) / kPixel);
    EXPECT_GT(touch.normal.dot(touch.point.normalized()), 0.6);
    EXPECT_NEAR(touch.footprint, kPixel, 0.2 * kPixel);
  }
  EXPECT_LT(UpperMedian(misses), 0.5) << "pieces are long between views 30 degrees apart";
  EXPECT_LT(QuantileAbove(misses, 0.95), 1.5);
}

TEST(OutlineTargets, FrontierPointsBringBackWhatHasFallenIn) {
  const Mesh truth = Ball(5, 1, 0);
  const std::vector<PreparedView> views = Views(truth);
  const Silhouettes silhouettes(views, 1);
  const std::vector<FrontierPoint> frontier = FrontierPointsOf(views, silhouettes);
  ASSERT_GT(frontier.size(), 2000u);
  const Mesh dented = Dented(truth, frontier[frontier.size() / 2].point.normalized(), 0.15, 6);
  const SurfaceTargets with = OutlineTargets(dented, silhouettes, frontier),
                       without = OutlineTargets(dented, silhouettes);
  int deep = 0, asked = 0, asked_without = 0;
  for (int v = 0; v < dented.vertex_count(); ++v) {
    const double depth = (truth.points.row(v) - dented.points.row(v)).norm() / kPixel;
    if (depth < 4) continue;
    ++deep;
    asked += with.weight[v] > 0.03f && std::abs(with.offset[v] / kPixel - depth) < 1.5;
    asked_without += without.weight[v] > 0 && std::abs(without.offset[v] / kPixel - depth) < 1.5;
  }
  ASSERT_GT(deep, 30);
  EXPECT_GT(asked, 8);
  EXPECT_EQ(asked_without, 0) << "the bottom of a dent is on no outline of the surface's own";
}

TEST(OutlineTargets, WhatStandsOutOfMasksIsPulledIn) {
  const Mesh truth = Ball(5, 1, 0);
  const Silhouettes silhouettes(Views(truth), 1);
  const Mesh bumpy = Dented(truth, Eigen::Vector3d(1, 0, 0.2).normalized(), 0.1, -5);
  const SurfaceTargets with = OutlineTargets(bumpy, silhouettes),
                       without = OutlineTargets(bumpy, silhouettes, {}, {.violation_weight = 0});
  int outside = 0, in = 0, in_without = 0;
  for (int v = 0; v < bumpy.vertex_count(); ++v) {
    const Eigen::Vector3d x = bumpy.points.row(v);
    if (silhouettes.Within(x, 2)) continue;
    ++outside;
    in += with.offset[v] < -0.5 * kPixel;
    in_without += without.offset[v] < -0.5 * kPixel;
  }
  ASSERT_GT(outside, 30);
  EXPECT_GT(in, 0.9 * outside);
  EXPECT_LT(in_without, in);
}

TEST(OutlineTargets, WhatNoViewSeesOnTheOutlineHasNoWeight) {
  // A small ball in front of the large one in every view never forms the outline.
  const Mesh truth = Ball(4, 1, 0);
  const Silhouettes silhouettes(Views(truth), 1);
  Mesh both = truth, inner = Ball(3, 0.5, 0);
  const int outer = both.vertex_count();
  both.points.conservativeResize(outer + inner.vertex_count(), 3),
      both.points.bottomRows(inner.vertex_count()) = inner.points;
  const int faces = both.face_count();
  both.faces.conservativeResize(faces + inner.face_count(), 3),
      both.faces.bottomRows(inner.face_count()) = inner.faces.array() + outer;
  const SurfaceTargets targets = OutlineTargets(both, silhouettes);
  EXPECT_EQ(*std::max_element(targets.weight.begin() + outer, targets.weight.end()), 0);
  EXPECT_EQ(*std::max_element(targets.offset.begin() + outer, targets.offset.end()), 0);
  EXPECT_GT(*std::max_element(targets.weight.begin(), targets.weight.begin() + outer), 0.9f);
}

TEST(OutlineTargets, FarOutlinesAndEmptyMeshesSayNothing) {
  const Silhouettes silhouettes(Views(Ball(4, 1, 0)), 1);
  const SurfaceTargets far = OutlineTargets(Ball(3, 0.7, 0), silhouettes);  // 30 pixels inside
  EXPECT_EQ(*std::max_element(far.weight.begin(), far.weight.end()), 0);
  EXPECT_TRUE(OutlineTargets(Mesh{}, silhouettes).offset.empty());
}

TEST(OutlineTargets, SameBitsForAnyThreadCount) {
  const Mesh truth = Ball(4, 1, 0.08);
  const Silhouettes silhouettes(Views(truth), 1);
  SetThreadCount(1);
  const SurfaceTargets one = OutlineTargets(Shifted(truth, 1), silhouettes);
  SetThreadCount(3);
  const SurfaceTargets three = OutlineTargets(Shifted(truth, 1), silhouettes);
  SetThreadCount(0);
  EXPECT_EQ(one.offset, three.offset);
  EXPECT_EQ(one.weight, three.weight);
}

}  // namespace keypose::reconstruct::outlines_test
