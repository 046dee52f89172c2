#include "deform/mending/mend.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::mend_test {

using Eigen::Vector3d;
using ::testing::HasSubstr;

MendStroke::Place PlaceAt(const Mesh& mesh, const Vector3d& point) {
  const RayScene::Foot foot = RayScene(mesh.points, mesh.faces).ClosestPoint(point);
  return {foot.face, foot.barycentric};
}

MendStroke Stroke(const Mesh& mesh, MendTool tool, double radius, double strength,
                  const std::vector<Vector3d>& places) {
  MendStroke stroke{tool, radius, strength, {}};
  for (const Vector3d& place : places) stroke.places.push_back(PlaceAt(mesh, place));
  return stroke;
}

/// A square of 2 x 2 in z = 0, from -1 to 1, with `cells` quads a side, each split in two.
Mesh Square(int cells) {
  Mesh mesh;
  const int row = cells + 1;
  mesh.points.resize(row * row, 3);
  mesh.faces.resize(2 * cells * cells, 3);
  for (int y = 0; y < row; ++y)
    for (int x = 0; x < row; ++x)
      mesh.points.row(y * row + x) << 2.0 * x / cells - 1, 2.0 * y / cells - 1, 0;
  for (int y = 0; y < cells; ++y)
    for (int x = 0; x < cells; ++x) {
      const int a = y * row + x, f = 2 * (y * cells + x);
      mesh.faces.row(f) << a, a + 1, a + row + 1;
      mesh.faces.row(f + 1) << a, a + row + 1, a + row;
    }
  return mesh;
}

/// The unit sphere, bitten at its top: to a depth of 0.2 within 0.25 of it.
Mesh BittenSphere() {
  Mesh mesh = MakeIcosphere(5);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
    const double away = (mesh.points.row(v).transpose() - Vector3d::UnitZ()).norm() / 0.25;
    if (away < 1) mesh.points.row(v) *= 1 - 0.2 * std::sqrt(1 - away * away);
  }
  return mesh;
}

double MostOffSphere(const PointsX3& points) {
  return (points.rowwise().norm().array() - 1).abs().maxCoeff();
}

TEST(Mend, FillGivesABittenSphereItsShapeBack) {
  const Mesh mesh = BittenSphere();
  EXPECT_GT(MostOffSphere(mesh.points), 0.19);
  const Mended mended = Mend(mesh, {Stroke(mesh, MendTool::kFill, 0.36, 1, {{0, 0, 1}})}, nullptr);
  // A thin plate over a cap of 21 degrees: its middle by the parabola of the rim's slope.
  EXPECT_LT(MostOffSphere(mended.points), 0.004);  // 2 % of the bite
  EXPECT_GT(mended.done[0].furthest, 0.19);
  EXPECT_NEAR(SignedVolume(mended.points, mesh.faces),
              SignedVolume(MakeIcosphere(5).points, mesh.faces), 2e-4);
  // No face turned over.
  const PointsX3 normals = FaceNormals(mended.points, mesh.faces);
  for (int f = 0; f < mesh.face_count(); ++f) {
    const Vector3d corner = mended.points.row(mesh.faces(f, 0));
    ASSERT_GT(normals.row(f).dot(corner), 0.9) << f;
  }
}

TEST(Mend, AFilledHoleInAPlaneIsThePlane) {
  Mesh mesh = Square(40);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    if (mesh.points.row(v).norm() < 0.3) mesh.points(v, 2) = -0.4;
  const Mended mended =
      Mend(mesh, {Stroke(mesh, MendTool::kFill, 0.5, 1, {{0, 0, -0.4}, {0.2, 0, -0.4}})}, nullptr);
  // The brush is 0.5 wide round the bite's floor, so it takes what is nearer than that to it.
  EXPECT_LT(mended.points.col(2).cwiseAbs().maxCoeff(), 1e-9);
  const Mended half = Mend(
      mesh, {Stroke(mesh, MendTool::kFill, 0.5, 0.5, {{0, 0, -0.4}, {0.2, 0, -0.4}})}, nullptr);
  EXPECT_NEAR(half.points.col(2).minCoeff(), -0.2, 1e-9);
}

TEST(Mend, SmoothTakesShortWavesAndLeavesLongOnes) {
  const double radius = 0.5;
  for (const double length : {radius / 2, 8 * radius}) {
    Mesh mesh = Square(80);
    const double wave = 2 * std::numbers::pi / length;
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
      mesh.points(v, 2) = 0.01 * std::cos(wave * mesh.points(v, 0));
    const Mended mended =
        Mend(mesh, {Stroke(mesh, MendTool::kSmooth, radius, 1, {{0, 0, 0.01}})}, nullptr);
    const int middle = 40 * 81 + 40;
    const double left = mended.points(middle, 2) / 0.01;
    EXPECT_NEAR(left, length < radius ? 0 : 1, 0.05) << length;
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) {
      const bool outside = (mesh.points.row(v) - mesh.points.row(middle)).norm() >= radius;
      ASSERT_TRUE(!outside || mended.points.row(v) == mesh.points.row(v)) << v;
    }
  }
}

TEST(Mend, SmoothKeepsASphereAndTakesItsNoise) {
  Mesh mesh = MakeIcosphere(5);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> noise(-0.01, 0.01);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) mesh.points.row(v) *= 1 + noise(random);
  const Mended mended = Mend(mesh, {Stroke(mesh, MendTool::kSmooth, 0.4, 1, {{0, 0, 1}})}, nullptr);
  const auto rms = [&](const PointsX3& points) {
    double sum = 0;
    int count = 0;
    for (Eigen::Index v = 0; v < points.rows(); ++v)
      if ((mesh.points.row(v).transpose() - Vector3d::UnitZ()).norm() < 0.15)
        ++count, sum += std::pow(points.row(v).norm() - 1, 2);
    return std::sqrt(sum / count);
  };
  EXPECT_NEAR(rms(mesh.points), 0.01 / std::sqrt(3), 0.001);
  EXPECT_LT(rms(mended.points), 0.0015);
}

TEST(Mend, PullMovesByTheRadiusAlongTheNormal) {
  const Mesh mesh = Square(40);
  const MendStroke out = Stroke(mesh, MendTool::kPull, 0.4, 0.5, {{0, 0, 0}});
  const Mended mended = Mend(mesh, {out}, nullptr);
  const int middle = 20 * 41 + 20;
  EXPECT_NEAR(mended.points(middle, 2), 0.2, 1e-12);
  EXPECT_NEAR(mended.points(middle + 4, 2), 0.2 * 0.5625, 1e-12);  // (1 - (0.2 / 0.4)^2)^2
  EXPECT_EQ(mended.points.leftCols(2), mesh.points.leftCols(2));
  EXPECT_NEAR(mended.done[0].furthest, 0.2, 1e-12);
  const MendStroke in = Stroke(mesh, MendTool::kPull, 0.4, -0.5, {{0, 0, 0}});
  EXPECT_NEAR(Mend(mesh, {in}, nullptr).points(middle, 2), -0.2, 1e-12);
  // The second begins where the first has brought the place to.
  EXPECT_NEAR(Mend(mesh, {out, out}, nullptr).points(middle, 2), 0.4, 1e-12);
}

TEST(Mend, APathMovesItsWholeLengthOnce) {
  const Mesh mesh = Square(40);
  const Mended mended =
      Mend(mesh, {Stroke(mesh, MendTool::kPull, 0.2, 1, {{-0.5, 0, 0}, {0, 0, 0}, {0.5, 0, 0}})},
           nullptr);
  for (int x = 10; x <= 30; ++x) EXPECT_NEAR(mended.points(20 * 41 + x, 2), 0.2, 1e-12);
}

TEST(Mend, TheOtherSideOfAThinPartStays) {
  Mesh top = Square(40), below = top;
  below.points.col(2).setConstant(-0.02);
  Mesh mesh = top;
  mesh.points.conservativeResize(2 * top.vertex_count(), 3);
  mesh.points.bottomRows(top.vertex_count()) = below.points;
  mesh.faces.conservativeResize(2 * top.face_count(), 3);
  mesh.faces.bottomRows(top.face_count()) = below.faces.array() + top.vertex_count();
  const Mended mended =
      Mend(mesh, {Stroke(mesh, MendTool::kPull, 0.3, 1, {{0, 0, 0.01}})}, nullptr);
  EXPECT_EQ(mended.points.bottomRows(top.vertex_count()), below.points);
}

std::string Fault(const Mesh& mesh, const MendStroke& stroke) {
  try {
    Mend(mesh, {Stroke(mesh, MendTool::kPull, 0.1, 0, {{0, 0, 1}}), stroke}, nullptr);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(Mend, NamesTheStrokeThatCannotBeDone) {
  const Mesh mesh = MakeIcosphere(2);
  EXPECT_THAT(Fault(mesh, Stroke(mesh, MendTool::kFill, 3, 1, {{0, 0, 1}})),
              HasSubstr("stroke 2 (fill): the brush covers a whole piece of the mesh"));
  EXPECT_THAT(Fault(mesh, Stroke(mesh, MendTool::kSmooth, 0, 1, {{0, 0, 1}})),
              HasSubstr("stroke 2 (smooth): its radius must be above 0"));
  EXPECT_THAT(Fault(mesh, Stroke(mesh, MendTool::kSmooth, 1, -1, {{0, 0, 1}})),
              HasSubstr("its strength must be from 0 to 1"));
  EXPECT_THAT(Fault(mesh, {MendTool::kPull, 1, 1, {{99999, Vector3d(1, 0, 0)}}}),
              HasSubstr("stroke 2 (pull): a place of the brush is on face 99999"));
}

TEST(Mend, ABrushSmallerThanTheTrianglesMovesNothing) {
  const Mesh mesh = MakeIcosphere(2);
  const Vector3d middle = (mesh.points.row(mesh.faces(0, 0)) + mesh.points.row(mesh.faces(0, 1)) +
                           mesh.points.row(mesh.faces(0, 2))) /
                          3;
  const Mended mended = Mend(mesh, {Stroke(mesh, MendTool::kFill, 0.01, 1, {middle})}, nullptr);
  EXPECT_EQ(mended.done[0].vertices, 0);
  EXPECT_EQ(mended.points, mesh.points);
}

}  // namespace keypose::mend_test
