// Renders of a striped ball serve as photographs: the evidence on correct and on wrong meshes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/pictures/render.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "report/evidence/verdict_limits.h"
#include "report/evidence/view_evidence.h"

namespace keypose::report::view_evidence_test {

/// An ellipsoid with stripes all round, so that no two sides are alike.
Mesh Figure(double width = 1) {
  Mesh mesh = MakeIcosphere(4);
  mesh.points.col(0) *= 0.6 * width;
  mesh.colors.resize(mesh.points.rows(), 3);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const double stripe =
        std::sin(14 * mesh.points(v, 2) + 6 * std::atan2(mesh.points(v, 1), mesh.points(v, 0)));
    for (int c = 0; c < 3; ++c) mesh.colors(v, c) = static_cast<std::uint8_t>(140 + 70 * stripe);
  }
  return mesh;
}

/// The figure's picture from a camera at this angle, and its exact mask.
Shot Photograph(const Mesh& mesh, double azimuth_deg, double light = 1) {
  Shot shot;
  shot.view = FitView(mesh.points, azimuth_deg, 15, 320, 280);
  shot.view.name = "at " + std::to_string(static_cast<int>(azimuth_deg));
  const RayScene scene(mesh.points, mesh.faces);
  RenderOptions look;
  look.shading = 0;
  look.background = {20, 40, 60};
  shot.photograph = Render(mesh, scene, shot.view, look);
  for (std::uint8_t& value : shot.photograph.data) value = static_cast<std::uint8_t>(value * light);
  const Raster raster = Rasterize(mesh, scene, shot.view);
  shot.mask = Image8(320, 280, 1);
  for (std::size_t i = 0; i < shot.mask.data.size(); ++i)
    shot.mask.data[i] = raster.face.data[i] >= 0 ? 255 : 0;
  return shot;
}

ViewEvidence Compared(const Mesh& mesh, const Shot& shot) {
  return CompareView(mesh, RayScene(mesh.points, mesh.faces), nullptr, Cropped(shot, mesh.points));
}

TEST(CompareView, TheTrueMeshFitsInAnyLight) {
  const Mesh mesh = Figure();
  for (const double light : {1.0, 0.6}) {
    const ViewEvidence e = Compared(mesh, Photograph(mesh, 30, light));
    EXPECT_EQ(e.iou, 1);
    EXPECT_EQ(e.outline_off, 0);
    EXPECT_GT(e.structure, 0.97);  // the photograph has 3 x 3 rays per pixel, the render 2 x 2
    EXPECT_GT(e.edges, 0.95);
  }
}

TEST(CompareView, OutlineDistanceIsThatOfTheSurfaceOverTheFiguresSize) {
  const Mesh mesh = Figure(), wide = Figure(1.05);
  const Shot shot = Photograph(mesh, 0);  // looks along y and sees the width
  // The half-axis of 0.6 grows by 0.03; along the outline of an ellipse of half-axes a, b the area
  // between the two is pi b da.
  const double a = 0.6, da = 0.03, b = 1, h = std::pow((a - b) / (a + b), 2);
  const double length = M_PI * (a + b) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
  const double expected = M_PI * b * da / length / std::hypot(2 * a, 2 * b);
  // The rim is a count of pixels, which is less than the length of a slanted line; perspective and
  // the camera's height cost a few per cent.
  EXPECT_NEAR(Compared(wide, shot).outline_off, expected, 0.35 * expected);
}

TEST(CompareView, AnotherSideOfTheFigureDoesNotFitInItsDetails) {
  const Mesh mesh = Figure();
  Shot shot = Photograph(mesh, 0);
  const Shot other = Photograph(mesh, 40);
  shot.photograph = other.photograph;
  shot.mask = other.mask;
  EXPECT_LT(Compared(mesh, shot).structure, kStructureWrong);
}

TEST(CompareView, AMaskThatCutsIntoTheFigureLeavesTheOutlineWithoutEdges) {
  const Mesh mesh = Figure(), thin = [] {
    Mesh m = Figure();
    m.points *= 0.85;
    return m;
  }();
  Mesh plain = mesh;
  plain.colors.setConstant(200);
  Shot shot = Photograph(plain, 10);
  EXPECT_GT(Compared(plain, shot).edges, 0.95);
  EXPECT_LT(Compared(thin, shot).edges, kEdgesGood);
}

TEST(CompareView, AMeshOutsideOfThePictureHasNothingInCommon) {
  const Mesh mesh = Figure();
  const Shot shot = Photograph(mesh, 0);
  Mesh away = mesh;
  away.points.rowwise() += Eigen::RowVector3d(0, 0, 50);
  EXPECT_EQ(Compared(away, shot).outline_off, 1);
}

TEST(CompareView, SameBitsForAnyThreadCount) {
  const Mesh mesh = Figure(), wide = Figure(1.05);
  const Shot shot = Photograph(mesh, 0);
  SetThreadCount(1);
  const ViewEvidence one = Compared(wide, shot);
  SetThreadCount(4);
  const ViewEvidence four = Compared(wide, shot);
  SetThreadCount(0);
  EXPECT_EQ(one.structure, four.structure);
  EXPECT_EQ(one.outline_off, four.outline_off);
}

TEST(Summarize, OneBadViewOfManyMovesNothingButIsFoundFirst) {
  std::vector<ViewEvidence> views(9);
  for (ViewEvidence& v : views) v.outline_off = 0.001, v.structure = 0.9, v.edges = 1;
  views[4].outline_off = 0.5;
  views[2].structure = 0.5;
  const PoseEvidence pose = Summarize(views);
  EXPECT_EQ(pose.outline_off, 0.001);
  EXPECT_EQ(pose.structure, 0.9);
  EXPECT_EQ(pose.worst, (std::vector<int>{4, 2, 0}));
}

TEST(SideBySide, ShowsPhotographAndRenderOfOneSizeWithTheMasksOutline) {
  const Mesh mesh = Figure();
  const Shot shot = Photograph(mesh, 0);
  const Image8 pair = SideBySide(mesh, RayScene(mesh.points, mesh.faces), nullptr, shot);
  EXPECT_EQ(pair.width, 2 * 320 + 6);
  EXPECT_EQ(pair.height, 280);
}

}  // namespace keypose::report::view_evidence_test
