#include "core/surfaces/self_intersections.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <limits>
#include <random>
#include <set>

#include "core/io/meshes/mesh_io.h"
#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/testing/paths.h"
#include "core/values/errors.h"

namespace keypose::self_intersections_test {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Surface = CGAL::Surface_mesh<Kernel::Point_3>;

SelfIntersections Apart(const PointsX3& points, const FacesX3& faces) {
  return FindSelfIntersections(points, faces, TouchingFaces::kLeftOut);
}

Mesh Shifted(Mesh mesh, double x, double y, double z) {
  mesh.points.rowwise() += Eigen::RowVector3d(x, y, z);
  return mesh;
}

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both;
  both.points.resize(a.vertex_count() + b.vertex_count(), 3);
  both.points << a.points, b.points;
  both.faces.resize(a.face_count() + b.face_count(), 3);
  both.faces << a.faces, (b.faces.array() + a.vertex_count()).matrix();
  return both;
}

struct CgalPairs {
  bool manifold = false;  ///< CGAL's own function needs a manifold
  std::int64_t all = 0;
  std::int64_t apart = 0;  ///< pairs that share no vertex
  std::vector<int> faces;  ///< of all pairs
};

CgalPairs PairsByCgal(const Mesh& mesh) {
  Surface surface;
  std::vector<Surface::Vertex_index> v;
  for (int i = 0; i < mesh.vertex_count(); ++i)
    v.push_back(surface.add_vertex({mesh.points(i, 0), mesh.points(i, 1), mesh.points(i, 2)}));
  CgalPairs found;
  for (int f = 0; f < mesh.face_count(); ++f)
    if (surface.add_face(v[mesh.faces(f, 0)], v[mesh.faces(f, 1)], v[mesh.faces(f, 2)]) ==
        Surface::null_face())
      return found;
  found.manifold = true;
  std::vector<std::pair<Surface::Face_index, Surface::Face_index>> pairs;
  CGAL::Polygon_mesh_processing::self_intersections(surface, std::back_inserter(pairs));
  std::set<int> faces;
  for (const auto& [face_a, face_b] : pairs) {
    const int a = static_cast<int>(face_a.idx()), b = static_cast<int>(face_b.idx());
    bool share = false;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) share = share || mesh.faces(a, i) == mesh.faces(b, j);
    ++found.all;
    found.apart += !share;
    faces.insert(a);
    faces.insert(b);
  }
  found.faces.assign(faces.begin(), faces.end());
  return found;
}

/// All pairs, by exact arithmetic only.
std::int64_t PairsByBruteForce(const PointsX3& p, const FacesX3& faces) {
  std::int64_t count = 0;
  const auto triangle = [&](int f) {
    const auto at = [&](int k) {
      return Kernel::Point_3(p(faces(f, k), 0), p(faces(f, k), 1), p(faces(f, k), 2));
    };
    return Kernel::Triangle_3(at(0), at(1), at(2));
  };
  for (int a = 0; a < faces.rows(); ++a)
    for (int b = a + 1; b < faces.rows(); ++b)
      count += CGAL::do_intersect(triangle(a), triangle(b));
  return count;
}

TEST(FindSelfIntersections, ClosedConvexSurfacesHaveNone) {
  const Mesh sphere = MakeIcosphere(4);
  EXPECT_EQ(Apart(sphere.points, sphere.faces).pairs, 0);
  // The side of a tube has many coplanar neighbours.
  const Mesh tube = MakeCylinder(0.1, 2, 24, 60);
  const SelfIntersections found = Apart(tube.points, tube.faces);
  EXPECT_EQ(found.pairs, 0);
  EXPECT_TRUE(found.faces.empty());
}

TEST(FindSelfIntersections, CrossingBoxesGiveThePairsOfTheirCrossingFaces) {
  const Mesh crossing = Joined(MakeBox(1, 1, 1), Shifted(MakeBox(1, 1, 1), 0.5, 0.4, 0.3));
  const std::int64_t expected = PairsByCgal(crossing).apart;
  EXPECT_EQ(Apart(crossing.points, crossing.faces).pairs, expected);
  EXPECT_GT(expected, 0);
  const Mesh apart = Joined(MakeBox(1, 1, 1), Shifted(MakeBox(1, 1, 1), 1 + 1e-12, 0, 0));
  EXPECT_EQ(Apart(apart.points, apart.faces).pairs, 0);
}

TEST(FindSelfIntersections, TouchingCounts) {
  // Two boxes with sides in one plane: each of the two faces there intersects both of the other
  // box, and touching edges count as well.
  const Mesh touching = Joined(MakeBox(1, 1, 1), Shifted(MakeBox(1, 1, 1), 1, 0, 0));
  EXPECT_EQ(Apart(touching.points, touching.faces).pairs, PairsByCgal(touching).apart);
}

TEST(FindSelfIntersections, RandomTrianglesAgreeWithExactArithmetic) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  for (double size : {0.02, 0.2, 1.0}) {
    PointsX3 points(3 * 400, 3);
    FacesX3 faces(400, 3);
    for (int f = 0; f < 400; ++f) {
      const Eigen::RowVector3d centre(unit(random), unit(random), unit(random));
      for (int k = 0; k < 3; ++k) {
        points.row(3 * f + k) =
            centre + size * Eigen::RowVector3d(unit(random), unit(random), unit(random));
        faces(f, k) = 3 * f + k;
      }
    }
    EXPECT_EQ(Apart(points, faces).pairs, PairsByBruteForce(points, faces)) << size;
    // On a coarse lattice nearly every sign is zero, so the exact arithmetic is used.
    for (Eigen::Index i = 0; i < points.size(); ++i)
      points.data()[i] = std::round(points.data()[i] * 6);
    std::vector<int> proper;
    for (int f = 0; f < 400; ++f) {
      const Eigen::RowVector3d u = points.row(3 * f + 1) - points.row(3 * f),
                               v = points.row(3 * f + 2) - points.row(3 * f);
      if (u.cross(v).norm() > 0) proper.push_back(f);
    }
    FacesX3 kept(std::ssize(proper), 3);
    for (std::size_t i = 0; i < proper.size(); ++i) kept.row(i) = faces.row(proper[i]);
    EXPECT_EQ(Apart(points, kept).pairs, PairsByBruteForce(points, kept)) << size;
  }
}

TEST(FindSelfIntersections, FacesWithoutAreaCountAsSegmentsAndPoints) {
  PointsX3 points(9, 3);
  points << 0, 0, 0, 4, 0, 0, 0, 4, 0,        // a triangle
      1, 1, -1, 1, 1, 0, 1, 1, 1,             // a segment through it
      0.5, 0.5, 0, 0.5, 0.5, 0, 0.5, 0.5, 0;  // a point on it
  FacesX3 faces(3, 3);
  faces << 0, 1, 2, 3, 4, 5, 6, 7, 8;
  EXPECT_EQ(Apart(points, faces).pairs, 2);
  EXPECT_EQ(Apart(points, faces).faces, (std::vector<int>{0, 1, 2}));
  // on the segment, off the triangle
  points.bottomRows(3).rowwise() = Eigen::RowVector3d(1, 1, 0.25);
  EXPECT_EQ(Apart(points, faces).pairs, 2);
  points.bottomRows(3).rowwise() = Eigen::RowVector3d(1, 1.5, 0.25);
  EXPECT_EQ(Apart(points, faces).pairs, 1);
}

TEST(FindSelfIntersections, FacesAtOneVertexThatCrossCountWhenTouchingFacesDo) {
  PointsX3 points(5, 3);
  points << 0, 0, 0, 2, -1, 0, 2, 1, 0, 2, 0, -1, 2, 0, 1;
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 0, 3, 4;
  EXPECT_EQ(Apart(points, faces).pairs, 0);
  const SelfIntersections counted = FindSelfIntersections(points, faces, TouchingFaces::kCounted);
  EXPECT_EQ(counted.pairs, 1);
  EXPECT_EQ(counted.faces, (std::vector<int>{0, 1}));
  points.bottomRows(2).col(0).array() = -2;  // they only meet in the vertex
  EXPECT_EQ(FindSelfIntersections(points, faces, TouchingFaces::kCounted).pairs, 0);
}

TEST(FindSelfIntersections, FacesOnOneEdgeCountWhenFoldedFlat) {
  PointsX3 points(4, 3);
  points << 0, 0, 0, 1, 0, 0, 0.3, 1, 0, 0.6, 0.5, 0;
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 1, 0, 3;
  EXPECT_TRUE(HasSelfIntersections(points, faces, TouchingFaces::kCounted));
  EXPECT_FALSE(HasSelfIntersections(points, faces, TouchingFaces::kLeftOut));
  points(3, 2) = 1e-300;  // exactly: the smallest angle is not a fold
  EXPECT_FALSE(HasSelfIntersections(points, faces, TouchingFaces::kCounted));
  points.row(3) << 0.6, -0.5, 0;
  EXPECT_FALSE(HasSelfIntersections(points, faces, TouchingFaces::kCounted));
}

TEST(FindSelfIntersections, AFaceWithoutAreaIsAPairWithItselfWhenTouchingFacesCount) {
  PointsX3 points(3, 3);
  points << 0, 0, 0, 1, 1, 1, 2, 2, 2;
  FacesX3 faces(1, 3);
  faces << 0, 1, 2;
  const SelfIntersections counted = FindSelfIntersections(points, faces, TouchingFaces::kCounted);
  EXPECT_EQ(counted.pairs, 1);
  EXPECT_EQ(counted.faces, std::vector<int>{0});
  EXPECT_EQ(Apart(points, faces).pairs, 0);
}

TEST(FindSelfIntersections, BadInputThrows) {
  Mesh sphere = MakeIcosphere(1);
  FacesX3 faces = sphere.faces;
  faces(3, 1) = 9999;
  EXPECT_THROW(Apart(sphere.points, faces), InputError);
  EXPECT_EQ(Apart(sphere.points, FacesX3(0, 3)).pairs, 0);
  sphere.points(2, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Apart(sphere.points, sphere.faces), InputError);
}

TEST(FindSelfIntersections, RealMeshesAgreeWithCgalAtAnyThreadCount) {
  const std::filesystem::path pairs = DataFolder() / "pairs";
  if (!std::filesystem::exists(pairs)) GTEST_SKIP() << "no data at " << pairs;
  int compared = 0;
  for (const char* name :
       {"wolf_rest_1", "cat_ref_07", "faust_000_008", "tosca_cat0_cat6", "cheb_rest_01"})
    for (const char* side : {"source.obj", "target.obj"}) {
      const Mesh mesh = ReadMesh(pairs / name / side);
      const CgalPairs expected = PairsByCgal(mesh);
      if (!expected.manifold) continue;
      ++compared;
      SetThreadCount(1);
      const SelfIntersections one = Apart(mesh.points, mesh.faces);
      SetThreadCount(3);
      const SelfIntersections three = Apart(mesh.points, mesh.faces);
      SetThreadCount(0);
      EXPECT_EQ(one.pairs, expected.apart) << name << ' ' << side;
      const SelfIntersections counted =
          FindSelfIntersections(mesh.points, mesh.faces, TouchingFaces::kCounted);
      EXPECT_EQ(counted.pairs, expected.all) << name << ' ' << side;
      EXPECT_EQ(counted.faces, expected.faces) << name << ' ' << side;
      EXPECT_EQ(HasSelfIntersections(mesh.points, mesh.faces, TouchingFaces::kCounted),
                expected.all > 0);
      EXPECT_EQ(one.pairs, three.pairs);
      EXPECT_EQ(one.faces, three.faces);
    }
  EXPECT_GE(compared, 6);
}

}  // namespace keypose::self_intersections_test
