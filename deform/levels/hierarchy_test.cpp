// Decimated meshes, the transfer of motion from them, and coordinates by distances to landmarks.
#include "deform/levels/hierarchy.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "core/numbers/parallel.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::hierarchy_test {

Mesh AsMesh(const CoarseLevel& level) {
  Mesh mesh;
  mesh.points = level.points;
  mesh.faces = level.faces;
  return mesh;
}

void ExpectWellFormed(const Mesh& mesh, const std::vector<CoarseLevel>& levels) {
  std::size_t finer = mesh.vertex_count();
  std::vector<int> finer_vertices(finer);
  std::iota(finer_vertices.begin(), finer_vertices.end(), 0);
  for (const CoarseLevel& level : levels) {
    ASSERT_EQ(level.points.rows(), std::ssize(level.fine));
    EXPECT_LT(level.fine.size(), finer);
    EXPECT_EQ(std::set<int>(level.fine.begin(), level.fine.end()).size(), level.fine.size());
    for (std::size_t k = 0; k < level.fine.size(); ++k)
      EXPECT_EQ(level.points.row(k), mesh.points.row(level.fine[k]));
    ASSERT_EQ(level.up.size(), finer);
    for (std::size_t v = 0; v < finer; ++v) {
      ASSERT_GE(level.up[v], 0);
      ASSERT_LT(level.up[v], level.points.rows());
    }
    // A vertex that was not removed is its own ancestor.
    for (std::size_t k = 0; k < level.fine.size(); ++k) {
      const auto at = std::find(finer_vertices.begin(), finer_vertices.end(), level.fine[k]) -
                      finer_vertices.begin();
      EXPECT_EQ(level.up[at], static_cast<int>(k));
    }
    EXPECT_GE(level.faces.minCoeff(), 0);
    EXPECT_LT(level.faces.maxCoeff(), level.points.rows());
    for (Eigen::Index f = 0; f < level.faces.rows(); ++f)
      EXPECT_EQ(std::set<int>({level.faces(f, 0), level.faces(f, 1), level.faces(f, 2)}).size(),
                3u);
    finer = level.fine.size();
    finer_vertices = level.fine;
  }
}

/// Unit squares in the plane z = 0, n x n, each cut in two.
Mesh MakePlate(int n) {
  Mesh plate;
  plate.points.resize((n + 1) * (n + 1), 3);
  plate.faces.resize(2 * n * n, 3);
  for (int y = 0; y <= n; ++y)
    for (int x = 0; x <= n; ++x) plate.points.row(y * (n + 1) + x) << x, y, 0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      const int a = y * (n + 1) + x, f = 2 * (y * n + x);
      plate.faces.row(f) << a, a + 1, a + n + 2;
      plate.faces.row(f + 1) << a, a + n + 2, a + n + 1;
    }
  return plate;
}

TEST(MakeHierarchy, ClosedStaysClosedAndKeepsItsSize) {
  const Mesh tube = MakeCylinder(0.3, 2, 40, 60);
  const std::vector<CoarseLevel> levels = MakeHierarchy(tube.points, tube.faces, {1200, 400, 100});
  ASSERT_EQ(levels.size(), 3u);
  ExpectWellFormed(tube, levels);
  const int counts[] = {1200, 400, 100};
  for (int l = 0; l < 3; ++l) {
    EXPECT_EQ(levels[l].points.rows(), counts[l]);
    const ClosedReport report = CheckClosed(AsMesh(levels[l]));
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.euler, 2);
    EXPECT_EQ(report.components, 1);
    EXPECT_NEAR(report.volume, CheckClosed(tube).volume,
                (l == 2 ? 0.1 : 0.03) * CheckClosed(tube).volume);
  }
}

TEST(MakeHierarchy, LargeMeshesAreDecimatedInRounds) {
  const Mesh tube = MakeCylinder(0.3, 2, 220, 250);
  ASSERT_GT(tube.vertex_count(), 50000);
  const std::vector<int> counts = {35000, 9000, 1000};
  SetThreadCount(1);
  const std::vector<CoarseLevel> levels = MakeHierarchy(tube.points, tube.faces, counts);
  SetThreadCount(2);
  const std::vector<CoarseLevel> again = MakeHierarchy(tube.points, tube.faces, counts);
  SetThreadCount(0);
  ASSERT_EQ(levels.size(), counts.size());
  ExpectWellFormed(tube, levels);
  const double volume = CheckClosed(tube).volume;
  for (std::size_t l = 0; l < counts.size(); ++l) {
    EXPECT_EQ(levels[l].points.rows(), counts[l]);
    const ClosedReport report = CheckClosed(AsMesh(levels[l]));
    EXPECT_TRUE(report.closed());
    EXPECT_EQ(report.euler, 2);
    EXPECT_NEAR(report.volume, volume, (l == 2 ? 0.01 : 0.001) * volume);
    EXPECT_EQ(levels[l].fine, again[l].fine);
    EXPECT_EQ(levels[l].up, again[l].up);
    EXPECT_EQ(levels[l].faces, again[l].faces);
  }
}

TEST(MakeHierarchy, RoundsSlideAlongABoundaryAndStopWhereNothingMayGo) {
  const int n = 190;
  const Mesh plate = MakePlate(n);
  const std::vector<CoarseLevel> levels = MakeHierarchy(plate.points, plate.faces, {24000, 2000});
  ASSERT_EQ(levels.size(), 2u);
  ExpectWellFormed(plate, levels);
  for (const CoarseLevel& level : levels) {
    const double area = SurfaceArea(level.points, level.faces);
    EXPECT_GT(area, 0.97 * n * n);
    EXPECT_LE(area, n * n * (1 + 1e-12));
    const ClosedReport report = CheckClosed(AsMesh(level));
    EXPECT_EQ(report.components, 1);
    EXPECT_GT(report.bad_edges, 0);
    EXPECT_LT(report.bad_edges, 4 * n);  // the boundary is decimated as well
  }

  // Tetrahedra that do not touch: no vertex may be removed.
  Mesh scraps;
  const int count = 8000;
  scraps.points.resize(4 * count, 3);
  scraps.faces.resize(4 * count, 3);
  for (int k = 0; k < count; ++k) {
    scraps.points.middleRows<4>(4 * k) << 2 * k, 0, 0, 2 * k + 1, 0, 0, 2 * k, 1, 0, 2 * k, 0, 1;
    scraps.faces.middleRows<4>(4 * k) << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
    scraps.faces.middleRows<4>(4 * k).array() += 4 * k;
  }
  EXPECT_TRUE(MakeHierarchy(scraps.points, scraps.faces, {31000, 1000}).empty());
}

TEST(MakeHierarchy, OpenNonManifoldAndScrapsSurvive) {
  Mesh open = MakeCylinder(0.3, 2, 30, 40);
  open.faces.conservativeResize(open.faces.rows() * 2 / 3, 3);
  ExpectWellFormed(open, MakeHierarchy(open.points, open.faces, {400, 100}));

  // A fin on the tube with three faces at each of its edges, a repeated face, a face without area,
  // and a vertex without a face.
  Mesh wild = MakeCylinder(0.3, 2, 20, 40);
  const Eigen::Index faces = wild.faces.rows(), points = wild.points.rows();
  wild.points.conservativeResize(points + 2, 3);
  wild.points.row(points) << 2, 2, 2;
  wild.points.row(points + 1) << 7, 7, 7;
  wild.faces.conservativeResize(faces + 12, 3);
  for (int k = 0; k < 10; ++k)
    wild.faces.row(faces + k) << wild.faces(20 * k, 0), wild.faces(20 * k, 1),
        static_cast<int>(points);
  wild.faces.row(faces + 10) = wild.faces.row(5);
  wild.faces.row(faces + 11) << wild.faces(5, 0), wild.faces(5, 0), wild.faces(5, 1);
  const std::vector<CoarseLevel> levels = MakeHierarchy(wild.points, wild.faces, {400, 150});
  EXPECT_FALSE(levels.empty());
  for (const CoarseLevel& level : levels) {
    EXPECT_TRUE(level.points.allFinite());
    for (int up : level.up) ASSERT_TRUE(up >= 0 && up < level.points.rows());
    EXPECT_LT(level.faces.maxCoeff(), level.points.rows());
  }
}

TEST(MakeHierarchy, APlateThinsWithoutFolds) {
  const int n = 20;
  const Mesh plate = MakePlate(n);
  const std::vector<CoarseLevel> levels = MakeHierarchy(plate.points, plate.faces, {150});
  ASSERT_EQ(levels.size(), 1u);
  ExpectWellFormed(plate, levels);
  EXPECT_GT(SurfaceArea(levels[0].points, levels[0].faces), 0.8 * n * n);  // corners wear off
  EXPECT_LE(SurfaceArea(levels[0].points, levels[0].faces), n * n * (1 + 1e-12));  // no folds
}

TEST(MakeHierarchy, ThingsTooSmallToDecimateGiveNoLevel) {
  const Mesh box = MakeBox(1, 1, 1);
  EXPECT_TRUE(MakeHierarchy(box.points, box.faces, {7}).empty());
  EXPECT_TRUE(MakeHierarchy(box.points, box.faces, {}).empty());
}

TEST(Prolong, ReproducesARigidMotionExactly) {
  const Mesh tube = MakeCylinder(0.3, 2, 30, 50);
  const std::vector<CoarseLevel> levels = MakeHierarchy(tube.points, tube.faces, {200});
  ASSERT_EQ(levels.size(), 1u);
  const Prolongation p = MakeProlongation(tube.points, levels[0]);
  ASSERT_EQ(p.offset.size(), static_cast<std::size_t>(tube.vertex_count()) + 1);
  for (int i = 0; i < tube.vertex_count(); ++i) {
    ASSERT_GT(p.offset[i + 1], p.offset[i]);
    EXPECT_LE(p.offset[i + 1] - p.offset[i], Prolongation::kNodes);
    float sum = 0;
    for (int s = p.offset[i]; s < p.offset[i + 1]; ++s) sum += p.weight[s];
    EXPECT_NEAR(sum, 1, 1e-5);
  }
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(2.2, Eigen::Vector3d(1, 1, -3).normalized()).toRotationMatrix();
  const Eigen::RowVector3d shift(-4, 2, 9);
  const PointsX3 coarse = (levels[0].points * turn.transpose()).rowwise() + shift;
  const PointsX3 moved = Prolong(p, tube.points, levels[0].points, coarse,
                                 std::vector<Eigen::Matrix3d>(levels[0].points.rows(), turn));
  EXPECT_LT((moved - ((tube.points * turn.transpose()).rowwise() + shift)).cwiseAbs().maxCoeff(),
            1e-12);
}

TEST(Prolong, FollowsABendClosely) {
  const Mesh tube = MakeCylinder(0.2, 2, 30, 80);
  const auto bend = [](double z) { return 1.5 * z / 2; };
  const auto bent = [&](const PointsX3& points) {
    PointsX3 b = points;
    const double radius = 2 / 1.5;
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double a = bend(points(i, 2)), r = radius - points(i, 0);
      b.row(i) << radius - r * std::cos(a), points(i, 1), r * std::sin(a);
    }
    return b;
  };
  const std::vector<CoarseLevel> levels = MakeHierarchy(tube.points, tube.faces, {300});
  ASSERT_EQ(levels.size(), 1u);
  std::vector<Eigen::Matrix3d> turns;
  for (Eigen::Index k = 0; k < levels[0].points.rows(); ++k)
    turns.push_back(Eigen::AngleAxisd(bend(levels[0].points(k, 2)), Eigen::Vector3d::UnitY())
                        .toRotationMatrix());
  const PointsX3 moved = Prolong(MakeProlongation(tube.points, levels[0]), tube.points,
                                 levels[0].points, bent(levels[0].points), turns);
  EXPECT_LT((moved - bent(tube.points)).rowwise().norm().maxCoeff() / BoundingDiagonal(tube.points),
            0.01);
}

}  // namespace keypose::hierarchy_test
