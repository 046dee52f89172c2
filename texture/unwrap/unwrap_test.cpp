#include "texture/unwrap/unwrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "texture/charts/charts.h"
#include "texture/charts/parametrise.h"

namespace keypose::texture::unwrap_test {

/// A sphere with limbs: bumps along the axes.
Mesh Bumpy(int levels) {
  Mesh mesh = MakeIcosphere(levels);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    const Eigen::RowVector3d p = mesh.points.row(v);
    mesh.points.row(v) *= 1 + 0.9 * std::pow(p.cwiseAbs().maxCoeff(), 12) +
                          0.05 * std::sin(9 * p.x()) * std::cos(7 * p.y());
  }
  return mesh;
}

Mesh Torus(int n, int m) {
  Mesh mesh;
  mesh.points.resize(n * m, 3);
  mesh.faces.resize(2 * n * m, 3);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < m; ++j) {
      const double a = 2 * EIGEN_PI * i / n, b = 2 * EIGEN_PI * j / m;
      mesh.points.row(i * m + j) << (2 + 0.6 * std::cos(b)) * std::cos(a),
          (2 + 0.6 * std::cos(b)) * std::sin(a), 0.6 * std::sin(b);
      const int p = i * m + j, q = (i + 1) % n * m + j, r = (i + 1) % n * m + (j + 1) % m,
                s = i * m + (j + 1) % m;
      mesh.faces.row(2 * p) << p, q, r;
      mesh.faces.row(2 * p + 1) << p, r, s;
    }
  }
  return mesh;
}

/// A unit square of two triangles in the plane z = 0, with the texture coordinates `uvs`.
Mesh Square(const UvsX2& uvs) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 0, 2, 3;
  mesh.uvs = OnGrid(uvs);
  mesh.uv_faces = mesh.faces;
  return mesh;
}

UnwrapOptions Small() {
  UnwrapOptions options;
  options.texture_size = 512;
  return options;
}

UnwrapOptions Rigid() {
  UnwrapOptions options = Small();
  options.elastic_packing = false;
  options.enough_utilisation = 0;
  return options;
}

void ExpectProven(const Mesh& clean, const UnwrapResult& result) {
  const AtlasFaults faults = FindAtlasFaults(result.mesh);
  EXPECT_TRUE(faults.none()) << faults.flipped << " flipped, " << faults.crossings << " crossings, "
                             << faults.nested << " nested";
  EXPECT_EQ(result.mesh.points, clean.points);
  EXPECT_EQ(result.mesh.faces, clean.faces);
  EXPECT_TRUE(result.mesh.has_uvs());
}

/// Brute force over the centres of the texels: number of triangles that cover each.
int MostCovered(const Mesh& mesh, int size) {
  std::vector<int> count(static_cast<std::size_t>(size) * size, 0);
  for (int f = 0; f < mesh.face_count(); ++f) {
    Eigen::Vector2d p[3];
    for (int k = 0; k < 3; ++k) p[k] = mesh.uvs.row(mesh.uv_faces(f, k)).transpose() * size;
    const auto low = p[0].cwiseMin(p[1]).cwiseMin(p[2]).array().floor().cast<int>().eval();
    const auto high = p[0].cwiseMax(p[1]).cwiseMax(p[2]).array().ceil().cast<int>().eval();
    for (int y = std::max(low.y(), 0); y < std::min(high.y(), size); ++y) {
      for (int x = std::max(low.x(), 0); x < std::min(high.x(), size); ++x) {
        const Eigen::Vector2d c(x + 0.5, y + 0.5);
        bool inside = true;
        for (int k = 0; k < 3; ++k) {
          const Eigen::Vector2d a = p[k], b = p[(k + 1) % 3];
          inside = inside && (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x() > 1e-9;
        }
        count[static_cast<std::size_t>(y) * size + x] += inside;
      }
    }
  }
  return *std::max_element(count.begin(), count.end());
}

TEST(Unwrapped, CubeKeepsItsShapeExactly) {
  const Mesh cube = MakeBox(1, 1, 1);
  const UnwrapResult result = Unwrapped(cube, Rigid());
  ExpectProven(cube, result);
  EXPECT_NEAR(result.stretch.l2, 1, 1e-3);
  EXPECT_NEAR(result.stretch.conformal_mean, 1, 1e-3);
  EXPECT_GT(result.stretch.utilisation, 0.4);
}

TEST(Unwrapped, CharacterLikeShapeIsFlatDenseAndProven) {
  const Mesh clean = Bumpy(5);  // 20,480 faces
  const UnwrapResult result = Unwrapped(clean, {});
  ExpectProven(clean, result);
  EXPECT_LE(MostCovered(result.mesh, 1024), 1);
  EXPECT_GT(result.stretch.utilisation, 0.8);
  EXPECT_LT(result.stretch.conformal_mean, 1.15);
  EXPECT_LT(result.stretch.conformal_p99, 2);
  EXPECT_LT(result.stretch.area_deviation, 0.1);
  EXPECT_LT(result.charts, 60);
  EXPECT_GE(result.mesh.uvs.minCoeff(), 0);
  EXPECT_LE(result.mesh.uvs.maxCoeff(), 1);
}

TEST(Unwrapped, CylinderSideHasNoStretch) {
  const Mesh clean = MakeCylinder(0.3, 2, 48, 40);
  UnwrapOptions options = Rigid();
  options.max_distortion = 1.02;  // otherwise the round border of the caps may join the side
  const UnwrapResult result = Unwrapped(clean, options);
  ExpectProven(clean, result);
  EXPECT_LT(result.stretch.l2, 1.01);
  EXPECT_LT(result.stretch.area_deviation, 0.03);
}

TEST(Unwrapped, HandlesAreCutOpen) {
  const Mesh clean = Torus(60, 24);
  ExpectProven(clean, Unwrapped(clean, Small()));
}

TEST(Unwrapped, ChartsKeepTheGutter) {
  UnwrapOptions options = Small();
  options.gutter = 12;
  const UnwrapResult result = Unwrapped(Bumpy(4), options);
  // Comparing each texel's nearest vertex's chart is sufficient: vertices of two charts are never
  // closer than the gutter.
  std::vector<int> parent(result.mesh.uvs.rows());
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = static_cast<int>(i);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (int f = 0; f < result.mesh.face_count(); ++f)
    for (int k = 1; k < 3; ++k)
      parent[root(result.mesh.uv_faces(f, k))] = root(result.mesh.uv_faces(f, 0));
  double nearest = 1;
  for (int i = 0; i < std::ssize(parent); ++i)
    for (int j = 0; j < i; ++j)
      if (root(i) != root(j))
        nearest = std::min(nearest, (result.mesh.uvs.row(i) - result.mesh.uvs.row(j)).norm());
  EXPECT_GE(nearest * 512, 12);
}

TEST(Unwrapped, SizeOfTheMeshDoesNotMatter) {
  Mesh clean = Bumpy(3);
  const UnwrapResult unit = Unwrapped(clean, Small());
  clean.points *= 1024;  // exact in binary
  const UnwrapResult large = Unwrapped(clean, Small());
  EXPECT_EQ(unit.mesh.uv_faces, large.mesh.uv_faces);
  EXPECT_LT((unit.mesh.uvs - large.mesh.uvs).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(unit.texels_per_unit, 1024 * large.texels_per_unit, 1e-6 * unit.texels_per_unit);
}

TEST(Unwrapped, SameBitsForAnyThreadCount) {
  const Mesh clean = Bumpy(4);
  SetThreadCount(1);
  const UnwrapResult one = Unwrapped(clean, Small());
  SetThreadCount(2);
  const UnwrapResult two = Unwrapped(clean, Small());
  SetThreadCount(0);
  EXPECT_EQ(one.mesh.uvs, two.mesh.uvs);
  EXPECT_EQ(one.mesh.uv_faces, two.mesh.uv_faces);
}

TEST(Unwrapped, OpenMeshThrowsInputErrorThatSaysWhatToDo) {
  Mesh open = MakeIcosphere(2);
  open.faces.conservativeResize(open.faces.rows() - 1, 3);
  try {
    Unwrapped(open, {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("cleanup"), std::string::npos) << error.what();
  }
}

TEST(Unwrapped, EmptyMeshThrowsInputError) { EXPECT_THROW(Unwrapped(Mesh(), {}), InputError); }

TEST(Unwrapped, NanVertexThrowsInputError) {
  Mesh mesh = MakeIcosphere(2);
  mesh.points(3, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Unwrapped(mesh, {}), InputError);
}

TEST(FindAtlasFaults, SquareHasNone) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 1, 0, 1, 1, 0, 1;
  EXPECT_TRUE(FindAtlasFaults(Square(uvs)).none());
}

TEST(FindAtlasFaults, MirroredSquareIsFlipped) {
  UvsX2 uvs(4, 2);
  uvs << 1, 0, 0, 0, 0, 1, 1, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).flipped, 2);
}

TEST(FindAtlasFaults, TriangleWithoutAreaIsFlipped) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 0.5, 0.5, 1, 1, 0, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).flipped, 1);
}

TEST(FindAtlasFaults, SeesTwoChartsThatCrossAndOneInsideAnother) {
  UvsX2 uvs(4, 2);
  uvs << 0.1, 0.1, 0.9, 0.1, 0.9, 0.9, 0.1, 0.9;
  const Mesh large = Square(uvs);
  for (const bool nested : {false, true}) {
    Mesh both = large;
    both.points.conservativeResize(8, 3);
    both.points.bottomRows(4) = large.points;
    both.faces.conservativeResize(4, 3);
    both.faces.bottomRows(2) = large.faces.array() + 4;
    both.uv_faces = both.faces;
    both.uvs.conservativeResize(8, 2);
    const Eigen::RowVector2d shift =
        nested ? Eigen::RowVector2d(0.25, 0.25) : Eigen::RowVector2d(0.5, 0.5);
    both.uvs.bottomRows(4) = OnGrid((large.uvs * 0.5).rowwise() + shift);
    const AtlasFaults faults = FindAtlasFaults(both);
    EXPECT_EQ(faults.crossings > 0, !nested);
    EXPECT_TRUE(!nested || faults.nested == 1);
    EXPECT_EQ(faults.flipped, 0);
  }
}

TEST(FindAtlasFaults, FanThatWindsAroundTwiceCrossesItself) {
  // No triangle flips, but the fan covers the plane twice: only its boundary reveals that.
  const int n = 12;
  Mesh fan;
  fan.points = PointsX3::Zero(n + 2, 3);
  fan.uvs.resize(n + 2, 2);
  fan.uvs.row(n + 1) << 0.5, 0.5;
  fan.faces.resize(n, 3);
  for (int i = 0; i <= n; ++i) {
    const double angle = 3.8 * EIGEN_PI * i / n;
    fan.uvs.row(i) << 0.5 + (0.2 + 0.01 * i) * std::cos(angle),
        0.5 + (0.2 + 0.01 * i) * std::sin(angle);
    if (i < n) fan.faces.row(i) << n + 1, i, i + 1;
  }
  fan.uvs = OnGrid(fan.uvs);
  fan.uv_faces = fan.faces;
  const AtlasFaults faults = FindAtlasFaults(fan);
  EXPECT_EQ(faults.flipped, 0);
  EXPECT_GT(faults.crossings, 0);
}

TEST(FindAtlasFaults, OutsideOfTheSquareIsAFault) {
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 1.25, 0, 1.25, 1, 0, 1;
  EXPECT_EQ(FindAtlasFaults(Square(uvs)).outside, 2);
}

TEST(MeasureAtlasStretch, KnownAffineMap) {
  // The unit square onto 0.8 x 0.2: after scaling to equal area the map back stretches by 2 and
  // 1/2.
  UvsX2 uvs(4, 2);
  uvs << 0, 0, 0.8, 0, 0.8, 0.2, 0, 0.2;
  const AtlasStretch stretch = MeasureAtlasStretch(Square(uvs));
  EXPECT_NEAR(stretch.linf, 2, 1e-9);
  EXPECT_NEAR(stretch.l2, std::sqrt((4 + 0.25) / 2), 1e-9);
  EXPECT_NEAR(stretch.conformal_mean, 4, 1e-9);
  EXPECT_NEAR(stretch.area_deviation, 0, 1e-9);
  EXPECT_NEAR(stretch.utilisation, 0.16, 1e-9);
}

TEST(Stretches, RotationHasNone) {
  const Eigen::Vector2d s = Stretches({0, 0, 1}, {2, 0, 1}, {1, 3, 1}, {0, 0}, {0, 2}, {-3, 1});
  EXPECT_NEAR(s[0], 1, 1e-12);
  EXPECT_NEAR(s[1], 1, 1e-12);
}

TEST(Flattened, DevelopableStripBecomesItsOwnPlan) {
  const Mesh tube = MakeCylinder(0.5, 1, 32, 8);
  const Surface surface = MakeSurface(tube);
  std::vector<int> faces;  // a third of the way round the side
  for (int f = 0; f < tube.face_count(); ++f)
    if (std::abs(surface.normals(f, 2)) < 0.1 && surface.centers(f, 0) > 0.25) faces.push_back(f);
  const Chart chart = MakeChart(surface, faces);
  ASSERT_TRUE(chart.disk);
  const auto uvs = Flattened(surface, chart, 200);
  ASSERT_TRUE(uvs.has_value());
  EXPECT_LT(MeasureDistortion(surface, chart, *uvs).max, 1.001);
}

TEST(MakeChart, RingIsNoDiskAndPinchedVertexCountsTwice) {
  const Mesh tube = MakeCylinder(0.5, 1, 16, 4);
  const Surface surface = MakeSurface(tube);
  std::vector<int> side;
  for (int f = 0; f < tube.face_count(); ++f)
    if (std::abs(surface.normals(f, 2)) < 0.1) side.push_back(f);
  EXPECT_FALSE(MakeChart(surface, side).disk);
  // Two faces that share only a vertex: six local vertices, not connected.
  const int v = tube.faces(side[0], 0);
  for (const int f : side) {
    int shared = 0;
    for (int k = 0; k < 3; ++k)
      shared += (tube.faces.row(side[0]).array() == tube.faces(f, k)).any();
    if (shared != 1 || !(tube.faces.row(f).array() == v).any()) continue;
    const Chart pinched = MakeChart(surface, {side[0], f});
    EXPECT_EQ(pinched.vertices.size(), 6u);
    EXPECT_FALSE(pinched.disk);
    return;
  }
  FAIL() << "the tube has no such pair";
}

}  // namespace keypose::texture::unwrap_test
