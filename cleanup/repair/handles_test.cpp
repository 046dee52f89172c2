#include "cleanup/repair/handles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "cleanup/repair/handle_loops.h"
#include "cleanup/repair/intersections.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/size_of.h"

namespace keypose::cleanup::handles_test {

/// A sphere with a tube of the given radius from pole to pole, either outside in a half circle or
/// through its centre. The faces around both poles are removed, and the rims of 6 or 12 vertices
/// are joined by `rings` rings.
Mesh WithTube(bool outside) {
  Mesh sphere = MakeIcosphere(4);
  const Eigen::RowVector3d poles[2] = {sphere.points.row(0), -sphere.points.row(0)};
  std::vector<int> out;
  for (int f = 0; f < sphere.face_count(); ++f)
    for (int k = 0; k < 3; ++k)
      if ((sphere.points.row(sphere.faces(f, k)) - poles[0]).norm() < 1e-9 ||
          (sphere.points.row(sphere.faces(f, k)) - poles[1]).norm() < 1e-9) {
        out.push_back(f);
        break;
      }
  Mesh mesh = Without(sphere, out, 0);
  const Eigen::Vector3d axis = poles[0].transpose(), side = axis.unitOrthogonal();
  // The rims in order around the axis.
  std::vector<int> rim[2];
  for (int end = 0; end < 2; ++end) {
    for (int v = 0; v < mesh.vertex_count(); ++v)
      for (const int f : out)
        for (int k = 0; k < 3; ++k)
          if (sphere.faces(f, k) == v && (sphere.points.row(v) - poles[end]).norm() < 0.3 &&
              (sphere.points.row(v) - poles[end]).norm() > 1e-9 &&
              (rim[end].empty() || rim[end].back() != v))
            rim[end].push_back(v);
    const Eigen::Vector3d other = axis.cross(side);
    std::sort(rim[end].begin(), rim[end].end(), [&](int a, int b) {
      const auto angle = [&](int v) {
        return std::atan2(mesh.points.row(v).dot(other.transpose()),
                          mesh.points.row(v).dot(side.transpose()));
      };
      return angle(a) < angle(b);
    });
  }
  const int n = SizeOf(rim[0]), rings = 40, base = mesh.vertex_count(), faces = mesh.face_count();
  mesh.points.conservativeResize(base + (rings - 1) * n, 3);
  mesh.faces.conservativeResize(faces + 2 * n * rings, 3);
  for (int r = 1; r < rings; ++r)
    for (int i = 0; i < n; ++i) {
      const double t = static_cast<double>(r) / rings;
      const Eigen::Vector3d a = mesh.points.row(rim[0][i]), across = a - axis * axis.dot(a);
      // Outside: the axis is an arc that leaves one pole straight up and enters the other from
      // below. Its direction makes one full turn.
      const double angle = EIGEN_PI * t,
                   reach = outside ? 1.6 * std::sin(angle) * std::sin(angle) : 0,
                   height = outside ? std::cos(angle) * (1 + 0.8 * std::sin(angle)) : 1 - 2 * t;
      const Eigen::Vector3d along =
          outside ? Eigen::Vector3d(side * std::cos(2 * angle) - axis * std::sin(2 * angle)) : side;
      const Eigen::Vector3d turned = across - side * side.dot(across) + along * side.dot(across);
      mesh.points.row(base + (r - 1) * n + i) = (axis * height + side * reach + turned).transpose();
    }
  const auto at = [&](int r, int i) {
    return r == 0 ? rim[0][i % n] : r == rings ? rim[1][i % n] : base + (r - 1) * n + i % n;
  };
  int f = faces;
  for (int r = 0; r < rings; ++r)
    for (int i = 0; i < n; ++i) {
      mesh.faces.row(f++) << at(r, i), at(r + 1, i), at(r + 1, i + 1);
      mesh.faces.row(f++) << at(r, i), at(r + 1, i + 1), at(r, i + 1);
    }
  // The pole vertices have no face any more.
  std::vector<int> id(mesh.vertex_count(), -1);
  Mesh tidy;
  tidy.points.resize(mesh.vertex_count(), 3);
  int count = 0;
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    if ((mesh.points.row(v) - poles[0]).norm() < 1e-9 ||
        (mesh.points.row(v) - poles[1]).norm() < 1e-9)
      continue;
    id[v] = count;
    tidy.points.row(count++) = mesh.points.row(v);
  }
  tidy.points.conservativeResize(count, 3);
  tidy.faces = mesh.faces.unaryExpr([&](int v) { return id[v]; });
  if (!CheckClosed(tidy).closed())
    tidy.faces.bottomRows(2 * n * rings).col(1).swap(tidy.faces.bottomRows(2 * n * rings).col(2));
  return tidy;
}

void ExpectSphere(const HandlesResult& result) {
  EXPECT_TRUE(CheckClosed(result.mesh).closed());
  EXPECT_EQ(Genus(result.mesh), 0);
  EXPECT_FALSE(SelfIntersects(result.mesh));
}

TEST(WithoutHandles, TorusBecomesASphereAndKeepsTheRest) {
  const Mesh torus = MakeTorus(1, 0.35, 60, 24);
  const HandlesResult result = WithoutHandles(torus, 0);
  EXPECT_EQ(result.cut, 1);
  ExpectSphere(result);
  // Two of the sixty rings of quads were replaced by caps.
  EXPECT_NEAR(SignedVolume(result.mesh.points, result.mesh.faces),
              58.0 / 60 * SignedVolume(torus.points, torus.faces), 1e-3);
}

TEST(WithoutHandles, FatTorusWithASmallHoleGetsItFilled) {
  // The hole's rim (radius 0.15) is shorter than the loop around the tube (radius 0.85).
  const Mesh torus = MakeTorus(1, 0.85, 60, 60);
  const HandlesResult result = WithoutHandles(torus, 0);
  ExpectSphere(result);
  EXPECT_GT(SignedVolume(result.mesh.points, result.mesh.faces),
            SignedVolume(torus.points, torus.faces));
}

TEST(WithoutHandles, KeepsAsManyAsAskedAndCutsTheThinnestFirst) {
  Mesh thin = MakeTorus(1, 0.2, 60, 24);
  thin.points.rowwise() += Eigen::RowVector3d(5, 0, 0);
  const Mesh both = Together(MakeTorus(1, 0.35, 60, 24), thin);
  ASSERT_EQ(Genus(both), 2);
  const HandlesResult result = WithoutHandles(both, 1);
  EXPECT_EQ(result.cut, 1);
  EXPECT_EQ(Genus(result.mesh), 1);
  // The thick one is unchanged: all of its vertices are there.
  int left = 0;
  for (int v = 0; v < result.mesh.vertex_count(); ++v) left += result.mesh.points(v, 0) < 2;
  EXPECT_EQ(left, 60 * 24);
  ExpectSphere(WithoutHandles(both, 0));
}

TEST(WithoutHandles, ThinHandleOfASphereIsCutAndTheSphereStays) {
  const Mesh mug = WithTube(true);
  ASSERT_TRUE(CheckClosed(mug).closed());
  ASSERT_FALSE(SelfIntersects(mug));
  ASSERT_EQ(Genus(mug), 1);
  const HandlesResult result = WithoutHandles(mug, 0);
  ExpectSphere(result);
  EXPECT_EQ(result.cut, 1);
  EXPECT_NEAR(SignedVolume(result.mesh.points, result.mesh.faces),
              SignedVolume(mug.points, mug.faces), 2e-3);
}

TEST(WithoutHandles, ThinTunnelThroughASphereIsClosed) {
  const Mesh bead = WithTube(false);
  ASSERT_TRUE(CheckClosed(bead).closed());
  ASSERT_EQ(Genus(bead), 1);
  const HandlesResult result = WithoutHandles(bead, 0);
  ExpectSphere(result);
}

}  // namespace keypose::cleanup::handles_test
