#include "cleanup/repair/holes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "core/surfaces/geometry.h"
#include "core/values/size_of.h"

namespace keypose::cleanup::holes_test {

// Makes the heap return memory in another order of addresses: frees blocks of many sizes, each
// between two that stay.
class ShuffledHeap {
 public:
  explicit ShuffledHeap(unsigned seed) {
    std::mt19937 random(seed);
    std::vector<std::unique_ptr<char[]>> blocks;
    for (int i = 0; i < 400; ++i) {
      blocks.push_back(std::make_unique<char[]>(500 + random() % 100000));
      kept_.push_back(std::make_unique<char[]>(2000));
    }
  }

 private:
  std::vector<std::unique_ptr<char[]>> kept_;
};

using Ring = std::vector<Eigen::RowVector3d>;

// A wall from the rim up to a level ring, closed there by a point.
Mesh Bell(const Ring& rim) {
  const int n = SizeOf(rim);
  constexpr double kTop = 500;
  Mesh mesh;
  mesh.points.resize(2 * n + 1, 3);
  mesh.points.row(2 * n) << 0, 0, 2 * kTop;
  mesh.faces.resize(3 * n, 3);
  for (int i = 0; i < n; ++i) {
    mesh.points.row(i) = rim[i];
    mesh.points.row(n + i) << rim[i].x(), rim[i].y(), kTop;
    const int next = (i + 1) % n;
    mesh.faces.row(3 * i) << i, next, n + i;
    mesh.faces.row(3 * i + 1) << next, n + next, n + i;
    mesh.faces.row(3 * i + 2) << n + i, n + next, 2 * n;
  }
  return mesh;
}

// Whole numbers within a box: many triangles fill such a rim equally well, to the last bit.
Ring Tangle(unsigned seed, int n, int side, int high) {
  std::mt19937 random(seed);
  Ring rim;
  while (SizeOf(rim) < n) {
    const Eigen::RowVector3d x(random() % side, random() % side, random() % high);
    if (std::find(rim.begin(), rim.end(), x) == rim.end()) rim.push_back(x);
  }
  return rim;
}

Ring UnevenCircle(int n) {
  std::mt19937 random(5);
  Ring rim;
  for (int i = 0; i < n; ++i) {
    const double radius = 1 + 0.2 * static_cast<double>(random() % 1000) / 1000;
    rim.emplace_back(radius * std::cos(2 * M_PI * i / n), radius * std::sin(2 * M_PI * i / n), 0.1);
  }
  return rim;
}

TEST(Holes, AreFilledAlikeWhereverTheHeapPutsTheTriangulation) {
  for (unsigned number = 0; number < 120; ++number) {
    const Mesh bell = Bell(number % 2 == 0 ? Tangle(number, 20, 4, 6) : Tangle(number, 40, 4, 3));
    const Mesh first = FillHoles(bell, nullptr).mesh;
    for (unsigned seed = 1; seed <= 3; ++seed) {
      const ShuffledHeap shuffled(seed);
      const Mesh again = FillHoles(bell, nullptr).mesh;
      ASSERT_EQ(again.faces, first.faces) << "rim " << number << ", heap " << seed;
      ASSERT_EQ(again.points, first.points) << "rim " << number << ", heap " << seed;
    }
  }
}

// Between two lines that pass each other every pair of edges makes a tetrahedron.
TEST(Holes, ARimOfVeryManyTetrahedraHasRoom) {
  constexpr int kSide = 600;
  Ring rim;
  for (int i = 0; i < kSide; ++i) rim.emplace_back(0.05 * i, 0, 0);
  for (int i = 0; i < kSide; ++i) rim.emplace_back(0, 0.05 * i, 30);
  const HolesResult filled = FillHoles(Bell(rim), nullptr);
  EXPECT_EQ(filled.filled, 1);
  EXPECT_TRUE(CheckClosed(filled.mesh).finite);
}

// As where soles are cut at the ground.
TEST(Holes, ALevelRimIsFilledWithinItsPlaneByWellShapedTriangles) {
  const int n = 190;
  const Mesh bell = Bell(UnevenCircle(n));
  const HolesResult filled = FillHoles(bell, nullptr);
  ASSERT_EQ(filled.filled, 1);
  EXPECT_EQ(filled.fanned, 0);
  EXPECT_TRUE(CheckClosed(filled.mesh).closed());
  double area = 0, wanted = 0;
  for (int f = bell.face_count(); f < filled.mesh.face_count(); ++f) {
    const Eigen::RowVector3d a = filled.mesh.points.row(filled.mesh.faces(f, 0)),
                             b = filled.mesh.points.row(filled.mesh.faces(f, 1)),
                             c = filled.mesh.points.row(filled.mesh.faces(f, 2));
    const Eigen::RowVector3d normal = (b - a).cross(c - a) / 2;
    EXPECT_LT(normal.z(), 0) << "face " << f << " is turned over";
    area += normal.norm();
  }
  for (int i = 0; i < n; ++i)
    wanted += bell.points.row(i).cross(bell.points.row((i + 1) % n)).z() / 2;
  EXPECT_NEAR(area, wanted, 1e-9 * wanted);
}

TEST(FillHoles, RimThatDoesNotKeepApartInCgalsViewIsFilled) {
  const std::vector<Eigen::Vector3d> square = {{-1, 0, 0}, {-1, 0, 3}, {1, 0, 3}, {1, 0, 0}};
  EXPECT_TRUE(ApartInPlanarView(square, 4));
  // Seen along y, the first corner lies near the last one, but not on it.
  std::vector<Eigen::Vector3d> rim = {{-1, 0, 0}, {-1, 1, 3}, {1, 0, 0}, {-1 + 1e-9, 1, 0}};
  EXPECT_FALSE(ApartInPlanarView(rim, 4));
  for (int turn = 0; turn < 8; ++turn) {
    std::rotate(rim.begin(), rim.begin() + (turn % 2), rim.end());
    std::reverse(rim.begin(), rim.end());
    Mesh cone;
    cone.points.resize(5, 3);
    cone.faces.resize(4, 3);
    cone.points.row(4) << 0.3, -7, 5;
    for (int k = 0; k < 4; ++k) {
      cone.points.row(k) = rim[k].transpose();
      cone.faces.row(k) << (k + 1) % 4, k, 4;
    }
    const HolesResult result = FillHoles(cone, nullptr);
    EXPECT_EQ(result.filled, 1);
    EXPECT_EQ(CheckClosed(result.mesh).bad_edges, 0);
  }
}

}  // namespace keypose::cleanup::holes_test
