#include "core/surfaces/face_pairs.h"

#include <gtest/gtest.h>

#include "core/surfaces/shapes.h"

namespace keypose::face_pairs_test {

TEST(FindFacePairs, OfAClosedMeshAreAllEdgesInOrderWithTheirSides) {
  const Mesh ball = MakeIcosphere(1);
  const FacePairs found = FindFacePairs(ball.faces);
  ASSERT_EQ(static_cast<int>(found.pairs.size()), 3 * ball.face_count() / 2);
  const auto has = [&](int face, int from, int to) {
    for (int k = 0; k < 3; ++k)
      if (ball.faces(face, k) == from && ball.faces(face, (k + 1) % 3) == to) return true;
    return false;
  };
  for (std::size_t i = 0; i < found.pairs.size(); ++i) {
    const FacePairs::Pair& pair = found.pairs[i];
    EXPECT_LT(pair.a, pair.b);
    EXPECT_TRUE(has(pair.left, pair.a, pair.b)) << i;
    EXPECT_TRUE(has(pair.right, pair.b, pair.a)) << i;
    if (i == 0) continue;
    const FacePairs::Pair& before = found.pairs[i - 1];
    EXPECT_TRUE(before.a < pair.a || (before.a == pair.a && before.b < pair.b)) << i;
  }
}

TEST(FindFacePairs, BordersAndEdgesOfThreeFacesAreLeftOut) {
  FacesX3 faces(2, 3);
  faces << 0, 1, 2, 2, 1, 3;
  const FacePairs square = FindFacePairs(faces);
  ASSERT_EQ(square.pairs.size(), 1u);
  EXPECT_EQ(square.pairs[0].a, 1);
  EXPECT_EQ(square.pairs[0].left, 0);
  faces.conservativeResize(3, 3);
  faces.row(2) << 2, 1, 4;
  EXPECT_TRUE(FindFacePairs(faces).pairs.empty());
}

}  // namespace keypose::face_pairs_test
