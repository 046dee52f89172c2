#include "cleanup/strategies/cleanup.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cleanup/repair/intersections.h"
#include "cleanup/testing/damaged_meshes.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::cleanup::cleanup_test {

/// Faces that the plane x = `at` runs through.
int FacesRound(const Mesh& mesh, double at) {
  int count = 0;
  for (int f = 0; f < mesh.face_count(); ++f) {
    int above = 0;
    for (int k = 0; k < 3; ++k) above += mesh.points(mesh.faces(f, k), 0) > at;
    count += above == 1 || above == 2;
  }
  return count;
}

/// A sphere of radius 1 out of which a rod of radius 0.02 grows along x to 3: one surface.
Mesh BallWithThinLimb() {
  std::vector<Eigen::Vector2d> profile;  // radius and height, downwards
  for (int i = 0; i <= 150; ++i) profile.emplace_back(0.02, 3 - 2.0 * i / 150);
  for (int i = 1; i < 60; ++i)
    profile.emplace_back(std::sin(EIGEN_PI * i / 60), std::cos(EIGEN_PI * i / 60));
  Mesh mesh = MakeRevolved(profile, 32);
  mesh.points.col(0).swap(mesh.points.col(2));
  mesh.faces.col(1).swap(mesh.faces.col(2));
  return mesh;
}

TEST(MakeClosedManifold, ThinLimbKeepsEightFacesRound) {
  for (const char* remesh : {"uniform", "adaptive"}) {
    CleanupOptions options;
    options.faces = 8000;
    options.remesh = remesh;
    const CleanupResult result = MakeClosedManifold(BallWithThinLimb(), options);
    EXPECT_NEAR(result.mesh.face_count(), 8000, 80);
    for (double x = 1.2; x < 2.95; x += 0.05)
      EXPECT_GE(FacesRound(result.mesh, x), 8) << remesh << " " << x;
    EXPECT_GT(result.mesh.points.col(0).maxCoeff(), 2.98) << remesh;
  }
}

constexpr double kSphereVolume = 4 * EIGEN_PI / 3;

Mesh Moved(Mesh mesh, const Eigen::RowVector3d& by, double scale = 1) {
  mesh.points = (mesh.points * scale).rowwise() + by;
  return mesh;
}

template <class Keep>
Mesh WithFaces(Mesh mesh, Keep keep) {
  int count = 0;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (keep(f)) mesh.faces.row(count++) = mesh.faces.row(f).eval();
  mesh.faces.conservativeResize(count, 3);
  return mesh;
}

/// The mesh without the faces whose centre lies below z.
Mesh Above(const Mesh& mesh, double z) {
  return WithFaces(mesh, [&](int f) {
    return (mesh.points(mesh.faces(f, 0), 2) + mesh.points(mesh.faces(f, 1), 2) +
            mesh.points(mesh.faces(f, 2), 2)) /
               3 >=
           z;
  });
}

Mesh Soup(const Mesh& mesh) {
  Mesh out;
  out.points.resize(mesh.faces.rows() * 3, 3);
  out.faces.resize(mesh.faces.rows(), 3);
  for (int f = 0; f < mesh.face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      out.points.row(3 * f + k) = mesh.points.row(mesh.faces(f, k));
      out.faces(f, k) = 3 * f + k;
    }
  return out;
}

CleanupOptions Faces(int faces) {
  CleanupOptions options;
  options.faces = faces;
  return options;
}

void ExpectClosed(const Mesh& mesh) {
  const ClosedReport report = CheckClosed(mesh);
  EXPECT_TRUE(report.closed()) << report.bad_edges << " bad edges, " << report.bad_fans
                               << " bad fans, volume " << report.volume;
  EXPECT_FALSE(SelfIntersects(mesh));
}

TEST(MakeClosedManifold, GoodMeshComesBackBitForBit) {
  Mesh sphere = MakeIcosphere(3);
  sphere.colors = ColorsX3::Constant(sphere.points.rows(), 3, 77);
  const CleanupResult result = MakeClosedManifold(sphere, Faces(2000));
  EXPECT_EQ(result.strategy, "as-is");
  EXPECT_EQ(result.mesh.points, sphere.points);
  EXPECT_EQ(result.mesh.faces, sphere.faces);
  EXPECT_EQ(result.mesh.colors, sphere.colors);
}

TEST(MakeClosedManifold, CubeOfTwelveFacesStaysACube) {
  const Mesh cube = MakeBox(1, 1, 1);
  const CleanupResult result = MakeClosedManifold(cube, {});
  EXPECT_EQ(result.mesh.face_count(), 12);
  EXPECT_DOUBLE_EQ(result.volume, 1);
}

TEST(MakeClosedManifold, RefineReachesTheCountWithinOnePercent) {
  CleanupOptions options = Faces(3000);
  options.refine = true;
  const CleanupResult result = MakeClosedManifold(MakeIcosphere(3), options);
  ExpectClosed(result.mesh);
  EXPECT_NEAR(result.mesh.face_count(), 3000, 30);
  EXPECT_LT(result.to_input.max,
            2e-3);  // a facet of the input bulges by 2.2e-3 of the diagonal under the sphere
}

TEST(MakeClosedManifold, DenseSphereIsRemeshedEvenlyToTheCount) {
  for (const char* remesh : {"uniform", "adaptive"}) {
    CleanupOptions options = Faces(2000);
    options.remesh = remesh;
    const CleanupResult result = MakeClosedManifold(MakeIcosphere(5), options);
    ExpectClosed(result.mesh);
    EXPECT_NEAR(result.mesh.face_count(), 2000, 20) << remesh;
    EXPECT_NEAR(result.volume, kSphereVolume, 0.01 * kSphereVolume) << remesh;
    EXPECT_EQ(result.genus, 0);
    EXPECT_LT(result.from_input.max, 0.001);
    EXPECT_GT(result.mean_min_angle_deg, 48) << remesh;
    EXPECT_GT(result.min_angle_deg, 15) << remesh;
  }
}

TEST(MakeClosedManifold, HolesAreFilledWithTheCurvatureAround) {
  const Mesh sphere = MakeIcosphere(4);
  const Mesh holed = WithFaces(sphere, [](int f) { return f % 640 > 3; });
  const CleanupResult result = MakeClosedManifold(holed, Faces(6000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.strategy, "R2 fill");
  EXPECT_EQ(result.holes_filled, 8);
  EXPECT_NEAR(result.volume, kSphereVolume, 0.01 * kSphereVolume);
  for (int v = 0; v < result.mesh.vertex_count(); ++v)
    ASSERT_NEAR(result.mesh.points.row(v).norm(), 1, 0.01);
}

TEST(MakeClosedManifold, OpenBowlGetsAFlatLid) {
  const Mesh bowl = Above(MakeIcosphere(4), -0.2);
  const CleanupResult result = MakeClosedManifold(bowl, Faces(8000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.holes_filled, 1);
  EXPECT_GT(result.largest_hole_over_diag, 0.5);
  // Sphere above z = -0.2: pi h^2 (3 - h) / 3 with h = 1.2.
  EXPECT_NEAR(result.volume, EIGEN_PI * 1.44 * 1.8 / 3, 0.06);
  EXPECT_GT(result.mesh.points.col(2).minCoeff(), -0.3);
}

TEST(MakeClosedManifold, WhatWasNotRepairedIsMeasuredByItself) {
  const Mesh bowl = Above(MakeIcosphere(5), -0.2);
  const CleanupResult result = MakeClosedManifold(bowl, Faces(3000));
  ExpectClosed(result.mesh);
  // The lid is far from all of the input; the round part is not, and only a rim of an edge's width
  // (0.07 of a height of 1.2) is left out.
  EXPECT_GT(result.to_input.p99, 0.1);
  EXPECT_LT(result.undamaged_to_input.max, 0.002);
  EXPECT_LT(result.undamaged_from_input.max, 0.002);
  EXPECT_GT(result.undamaged_from_input.p99, 1e-5);
  EXPECT_NEAR(result.undamaged_share, 1 - 0.07 / 1.2, 0.03);
  const CleanupResult whole = MakeClosedManifold(MakeIcosphere(5), Faces(3000));
  EXPECT_EQ(whole.undamaged_share, 1);
  EXPECT_EQ(whole.undamaged_from_input.max, whole.from_input.max);
}

TEST(MakeClosedManifold, FlippedFacesAreTurned) {
  Mesh sphere = MakeIcosphere(3);
  for (int f = 0; f < sphere.face_count(); f += 3)
    std::swap(sphere.faces(f, 1), sphere.faces(f, 2));
  const CleanupResult result = MakeClosedManifold(sphere, Faces(2000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.strategy, "R0 weld");
  EXPECT_NEAR(result.volume, SignedVolume(MakeIcosphere(3).points, MakeIcosphere(3).faces),
              1e-7);  // positions sit on a grid of 1.5e-8
}

TEST(MakeClosedManifold, InsideOutIsTurnedOutward) {
  Mesh sphere = MakeIcosphere(2);
  sphere.faces.col(1).swap(sphere.faces.col(2));
  EXPECT_GT(MakeClosedManifold(sphere, Faces(2000)).volume, 0);
}

TEST(MakeClosedManifold, DuplicateShellsBecomeOne) {
  const Mesh sphere = MakeIcosphere(3);
  Mesh twin = sphere;
  twin.faces.col(1).swap(twin.faces.col(2));
  const CleanupResult result = MakeClosedManifold(Together(sphere, twin), Faces(2000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.mesh.face_count(), sphere.face_count());
  EXPECT_EQ(result.merged_vertices, sphere.vertex_count());
}

TEST(MakeClosedManifold, TriangleSoupIsWelded) {
  const Mesh sphere = MakeIcosphere(3);
  const CleanupResult result = MakeClosedManifold(Soup(sphere), Faces(2000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.mesh.vertex_count(), sphere.vertex_count());
  EXPECT_EQ(result.mesh.face_count(), sphere.face_count());
}

TEST(MakeClosedManifold, FinsAreCutOff) {
  Mesh sphere = MakeIcosphere(3);
  const int vertex_count = sphere.vertex_count(), face_count = sphere.face_count();
  sphere.points.conservativeResize(vertex_count + 3, 3);
  sphere.faces.conservativeResize(face_count + 3, 3);
  for (int i = 0; i < 3; ++i) {
    const int a = sphere.faces(100 * i, 0), b = sphere.faces(100 * i, 1);
    sphere.points.row(vertex_count + i) = 1.2 * sphere.points.row(a);
    sphere.faces.row(face_count + i) << a, b, vertex_count + i;
  }
  const CleanupResult result = MakeClosedManifold(sphere, Faces(2000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.mesh.face_count(), face_count);
  EXPECT_LT(result.mesh.points.rowwise().norm().maxCoeff(), 1.0001);
}

TEST(MakeClosedManifold, CrossingSpheresBecomeOneSurface) {
  const Mesh pair = Together(MakeIcosphere(3), Moved(MakeIcosphere(3), {1.1, 0, 0}));
  const CleanupResult result = MakeClosedManifold(pair, Faces(3000));
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.components, 1);
  EXPECT_EQ(result.strategy.substr(0, 2), "R4");
  EXPECT_GT(result.self_intersections_before, 0);
  // Two spheres less the lens between them; the wrap rounds the groove and polyhedra lie inside of
  // their spheres.
  const double h = 1 - 0.55, lens = 2 * EIGEN_PI * h * h * (3 - h) / 3;
  EXPECT_NEAR(result.volume, 2 * kSphereVolume - lens, 0.03 * kSphereVolume);
}

TEST(MakeClosedManifold, AWiderWrapFillsTheGrooveFurther) {
  const Mesh pair = Together(MakeIcosphere(3), Moved(MakeIcosphere(3), {1.1, 0, 0}));
  CleanupOptions narrow = Faces(3000), wide = Faces(3000);
  narrow.wrap_alpha = 0.01;
  wide.wrap_alpha = 0.15;
  EXPECT_LT(MakeClosedManifold(pair, narrow).volume, MakeClosedManifold(pair, wide).volume);
}

TEST(MakeClosedManifold, SpikePushedThroughTheOtherSideIsMended) {
  Mesh sphere = MakeIcosphere(4);
  int top = 0;
  sphere.points.col(2).maxCoeff(&top);
  sphere.points.row(top) << 0, 0, -1.2;
  const CleanupResult result = MakeClosedManifold(sphere, Faces(6000));
  ExpectClosed(result.mesh);
  EXPECT_GT(result.self_intersections_before, 0);
  EXPECT_NEAR(result.volume, kSphereVolume, 0.05 * kSphereVolume);
}

TEST(MakeClosedManifold, SmallBitsAreDroppedAndFarPiecesToo) {
  const Mesh main = MakeIcosphere(3);
  const Mesh scene = Together(Together(main, Moved(MakeIcosphere(1), {3, 0, 0}, 0.02)),
                              Moved(MakeIcosphere(2), {0, 4, 0}, 0.5));
  const CleanupResult one = MakeClosedManifold(scene, Faces(2000));
  ExpectClosed(one.mesh);
  EXPECT_EQ(one.components, 1);
  EXPECT_EQ(one.components_removed, 2);
  EXPECT_EQ(one.mesh.face_count(), main.face_count());
  CleanupOptions all = Faces(4000);
  all.keep_components = 0;
  all.min_component = 0;
  const CleanupResult kept = MakeClosedManifold(scene, all);
  EXPECT_EQ(kept.components, 3);
  EXPECT_EQ(kept.components_removed, 0);
}

TEST(MakeClosedManifold, ColoursComeFromTheNearestSurface) {
  Mesh sphere = MakeIcosphere(5);
  sphere.colors.resize(sphere.points.rows(), 3);
  for (int v = 0; v < sphere.vertex_count(); ++v)
    sphere.colors.row(v).setConstant(
        static_cast<std::uint8_t>(std::lround(127 + 100 * sphere.points(v, 2))));
  const CleanupResult result = MakeClosedManifold(sphere, Faces(1500));
  ASSERT_EQ(result.mesh.colors.rows(), result.mesh.points.rows());
  for (int v = 0; v < result.mesh.vertex_count(); ++v)
    ASSERT_NEAR(result.mesh.colors(v, 1), 127 + 100 * result.mesh.points(v, 2), 3);
}

TEST(MakeClosedManifold, AnotherUnitGivesTheSameFacesAndScaledPositions) {
  const Mesh scene =
      Together(Above(MakeFigure(4, 3), -0.02), Moved(MakeIcosphere(1), {0.3, 0, 0}, 0.001));
  for (const int faces : {1000, 20000}) {  // remeshed, and only filled
    const CleanupResult unit = MakeClosedManifold(scene, Faces(faces));
    for (const double scale : {1e-3, 1e3}) {
      const CleanupResult scaled = MakeClosedManifold(Moved(scene, {0, 0, 0}, scale), Faces(faces));
      EXPECT_EQ(scaled.strategy, unit.strategy);
      ASSERT_EQ(scaled.mesh.faces, unit.mesh.faces);
      const double diagonal = BoundingDiagonal(unit.mesh.points);
      EXPECT_LT((scaled.mesh.points / scale - unit.mesh.points).cwiseAbs().maxCoeff(),
                1e-12 * diagonal);
    }
  }
}

TEST(MakeClosedManifold, CleaningTwiceChangesNothing) {
  for (const Mesh& mesh :
       {Above(MakeIcosphere(4), -0.5), Above(MakeFigure(2, 1), -0.02), MakeTorus(1, 0.4, 60, 24)})
    for (const char* remesh : {"uniform", "adaptive"}) {
      CleanupOptions options = Faces(1500);
      options.remesh = remesh;
      const CleanupResult once = MakeClosedManifold(mesh, options);
      const CleanupResult twice = MakeClosedManifold(once.mesh, options);
      EXPECT_EQ(twice.strategy, "as-is");
      EXPECT_EQ(twice.mesh.points, once.mesh.points);
      EXPECT_EQ(twice.mesh.faces, once.mesh.faces);
    }
}

TEST(MakeClosedManifold, SameBitsForAnyThreadCount) {
  const Mesh scene = Together(Above(MakeIcosphere(3), -0.5), Moved(MakeBox(1, 1, 1), {0.5, 0, 0}));
  SetThreadCount(1);
  const CleanupResult one = MakeClosedManifold(scene, Faces(1500));
  SetThreadCount(2);
  const CleanupResult two = MakeClosedManifold(scene, Faces(1500));
  SetThreadCount(0);
  EXPECT_EQ(one.mesh.points, two.mesh.points);
  EXPECT_EQ(one.mesh.faces, two.mesh.faces);
  EXPECT_EQ(one.to_input.mean, two.to_input.mean);
}

TEST(MakeClosedManifold, TorusKeepsItsHandleWhenAsked) {
  CleanupOptions keep = Faces(1000);
  keep.genus = -1;
  const CleanupResult result = MakeClosedManifold(MakeTorus(2, 0.6, 40, 20), keep);
  ExpectClosed(result.mesh);
  EXPECT_EQ(result.genus, 1);
}

TEST(MakeClosedManifold, EmptyMeshThrowsInputError) {
  EXPECT_THROW(MakeClosedManifold(Mesh(), {}), InputError);
  Mesh points = MakeIcosphere(1);
  points.faces.resize(0, 3);
  EXPECT_THROW(MakeClosedManifold(points, {}), InputError);
}

TEST(MakeClosedManifold, NanVertexThrowsInputErrorThatNamesIt) {
  Mesh sphere = MakeIcosphere(2);
  sphere.points(37, 1) = std::numeric_limits<double>::quiet_NaN();
  try {
    MakeClosedManifold(sphere, {});
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("37"), std::string::npos) << error.what();
  }
}

TEST(MakeClosedManifold, AllVerticesInOnePlaceThrowsInputError) {
  Mesh mesh = MakeIcosphere(1);
  mesh.points.setConstant(0.5);
  EXPECT_THROW(MakeClosedManifold(mesh, {}), InputError);
}

TEST(MakeClosedManifold, FacesWithoutDistinctCornersThrowInputError) {
  Mesh mesh = MakeIcosphere(1);
  mesh.faces.col(1) = mesh.faces.col(0);
  EXPECT_THROW(MakeClosedManifold(mesh, {}), InputError);
}

TEST(MakeClosedManifold, WhatCannotBeClosedSaysWhereAndWhy) {
  const auto message = [](const Mesh& mesh) -> std::string {
    try {
      MakeClosedManifold(mesh, {});
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  Mesh doubled = MakeIcosphere(1);
  doubled.faces.col(1) = doubled.faces.col(0);
  const std::string corner = std::to_string(doubled.faces(0, 0));
  EXPECT_NE(message(doubled).find("face 0 with its vertices " + corner + " and " + corner),
            std::string::npos)
      << message(doubled);
  // its third axis has another unit
  Mesh needle = MakeIcosphere(3);
  needle.points.col(2) *= 1e5;
  EXPECT_NE(message(needle).find("on a line"), std::string::npos) << message(needle);
  Mesh far = MakeIcosphere(1);
  far.points(5, 1) = 1e30;
  EXPECT_NE(message(far).find("vertex 5"), std::string::npos) << message(far);
}

TEST(MakeClosedManifold, WithoutTheWrapATangleIsAQualityError) {
  const Mesh pair = Together(MakeIcosphere(3), Moved(MakeIcosphere(3), {0.05, 0, 0}));
  CleanupOptions options = Faces(3000);
  options.wrap = false;
  EXPECT_THROW(MakeClosedManifold(pair, options), QualityError);
}

}  // namespace keypose::cleanup::cleanup_test
