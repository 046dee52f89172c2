// A skin around overlapping pieces: closed, near them, in one part; and landmarks suggested on it.
#include "register/intrinsic/skin.h"

#include <gtest/gtest.h>

#include <map>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/shapes.h"
#include "core/values/union_find.h"

namespace keypose::registration::skin_test {

Mesh Joined(const Mesh& one, const Mesh& other) {
  Mesh both;
  both.points.resize(one.vertex_count() + other.vertex_count(), 3);
  both.points << one.points, other.points;
  both.faces.resize(one.face_count() + other.face_count(), 3);
  both.faces << one.faces, other.faces.array() + one.vertex_count();
  return both;
}

Mesh Ball(double x, double radius = 1) {
  Mesh ball = MakeIcosphere(3);
  ball.points *= radius;
  ball.points.col(0).array() += x;
  return ball;
}

TEST(SkinOfPieces, LiesAroundTwoBallsThatOverlapAsOneClosedSurface) {
  const Mesh balls = Joined(Ball(-0.6), Ball(0.6));
  const auto skin = SkinOfPieces(balls);
  ASSERT_TRUE(skin);
  std::map<std::pair<int, int>, int> sides;
  UnionFind parts(skin->vertex_count());
  for (int f = 0; f < skin->face_count(); ++f)
    for (int k = 0; k < 3; ++k) {
      const int a = skin->faces(f, k), b = skin->faces(f, (k + 1) % 3);
      ++sides[{a, b}];
      parts.Join(a, b);
    }
  for (const auto& [side, count] : sides) {
    EXPECT_EQ(count, 1);
    EXPECT_EQ((sides.count({side.second, side.first})), 1u);
  }
  for (int v = 1; v < skin->vertex_count(); ++v) EXPECT_EQ(parts.Find(v), parts.Find(0));
  // Two unit balls whose centres are 1.2 apart: each loses a cap of height 0.4.
  const double cap = M_PI * 0.4 * 0.4 * (3 - 0.4) / 3;
  const double volume = 2 * (4 * M_PI / 3 - cap);
  EXPECT_NEAR(SignedVolume(skin->points, skin->faces), volume, 0.04 * volume);
  const double cell = 3.2 / 96;
  const RayScene scene(balls.points, balls.faces);
  for (int v = 0; v < skin->vertex_count(); ++v) {
    const auto foot = scene.ClosestPoint(skin->points.row(v));
    EXPECT_LT(std::sqrt(foot.squared_distance), 2 * cell);
    // None of the surface that lies within the other ball.
    EXPECT_GT(skin->points.row(v).tail<2>().norm() + std::abs(skin->points(v, 0)), 0.75);
  }
}

TEST(SkinOfPieces, LeavesAMeshThatIsMostlyOnePieceAsItIs) {
  EXPECT_FALSE(SkinOfPieces(Ball(0)));
  EXPECT_FALSE(SkinOfPieces(Joined(Ball(0), Ball(1, 0.3)))) << "an eye is no limb";
  EXPECT_TRUE(SkinOfPieces(Joined(Ball(0), Ball(1, 0.8))));
}

}  // namespace keypose::registration::skin_test
