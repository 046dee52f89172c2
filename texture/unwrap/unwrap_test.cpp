#include "texture/unwrap/unwrap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"
#include "texture/charts/charts.h"
#include "texture/testing/snowman.h"

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

TEST(Unwrapped, SeamRunsInTheDeepCreaseAndKeepsFromTheFront) {
  const Mesh figure = Snowman(5);
  UnwrapOptions options;
  options.elastic_packing = false;
  options.effort = 20;
  options.enough_utilisation = 0;
  const UnwrapResult hidden = Unwrapped(figure, options);
  options.hide_seams = false;
  const UnwrapResult plain = Unwrapped(figure, options);
  EXPECT_LT(hidden.seam_exposure, 0.9 * hidden.edge_exposure);
  EXPECT_LT(hidden.seam_exposure, plain.seam_exposure);
  EXPECT_LT(hidden.seam_front_over_diag, plain.seam_front_over_diag);
  // Share of the way around the waist that is seam: by angle, in 72 sectors.
  const Surface s = MakeSurface(figure);
  std::vector<char> sector(72, 0);
  for (int f = 0; f < figure.face_count(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const int a = figure.faces(f, k), b = figure.faces(f, (k + 1) % 3), g = s.neighbors(f, k);
      int at = 0;
      while (figure.faces(g, at) != a || figure.faces(g, (at + 2) % 3) != b) ++at;
      if (hidden.mesh.uv_faces(g, at) == hidden.mesh.uv_faces(f, k)) continue;
      const Eigen::RowVector3d m = (figure.points.row(a) + figure.points.row(b)) / 2;
      if (std::abs(m.z()) < 0.08)
        sector[std::min(71, static_cast<int>((std::atan2(m.y(), m.x()) / EIGEN_PI + 1) * 36))] = 1;
    }
  }
  EXPECT_GE(std::count(sector.begin(), sector.end(), 1), 60);
}

}  // namespace keypose::texture::unwrap_test
