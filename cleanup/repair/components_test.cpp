#include "cleanup/repair/components.h"

#include <gtest/gtest.h>

#include "cleanup/testing/damaged_meshes.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/shapes.h"

namespace keypose::cleanup::components_test {

Mesh Shifted(Mesh mesh, double x) {
  mesh.points.col(0).array() += x;
  return mesh;
}

/// Boxes of sides 1, 0.5 and 0.1 with gaps of 1 and 0.05.
Mesh ThreeBoxes() {
  return Together(Together(MakeBox(1, 1, 1), Shifted(MakeBox(0.5, 0.5, 0.5), 2)),
                  Shifted(MakeBox(0.1, 0.1, 0.1), 2.55));
}

TEST(FindPieces, MeasuresEachPieceInTheOrderOfItsFirstFace) {
  const Pieces pieces = FindPieces(ThreeBoxes());
  ASSERT_EQ(pieces.list.size(), 3u);
  const double sides[3] = {1, 0.5, 0.1};
  for (int p = 0; p < 3; ++p) {
    EXPECT_EQ(pieces.list[p].faces, 12);
    EXPECT_NEAR(pieces.list[p].area, 6 * sides[p] * sides[p], 1e-12);
    EXPECT_NEAR(pieces.list[p].volume, sides[p] * sides[p] * sides[p], 1e-12);
    EXPECT_EQ(pieces.of_face[12 * p], p);
  }
}

TEST(KeptPieces, KeepsFacesAndVerticesOfTheMarkedOnes) {
  const Mesh mesh = ThreeBoxes();
  const Mesh kept = KeptPieces(mesh, FindPieces(mesh), {0, 1, 0});
  EXPECT_EQ(kept.vertex_count(), 8);
  EXPECT_EQ(kept.face_count(), 12);
  EXPECT_NEAR(SignedVolume(kept.points, kept.faces), 0.125, 1e-12);
}

TEST(WithoutBits, DropsPiecesWithLessThanTheShareOfTheLargestArea) {
  int removed = 0;
  EXPECT_EQ(WithoutBits(ThreeBoxes(), 0.02, &removed).face_count(), 24);
  EXPECT_EQ(removed, 1);
}

TEST(WithTouchingPieces, GapsAreCrossedOneByOne) {
  int removed = 0;
  EXPECT_EQ(WithTouchingPieces(ThreeBoxes(), 0.3, &removed).face_count(), 12);
  EXPECT_EQ(removed, 2);
  EXPECT_EQ(WithTouchingPieces(ThreeBoxes(), 1.05, &removed).face_count(), 36);
  EXPECT_EQ(removed, 2);
}

TEST(LargestPieces, KeepsAsManyAsAskedAndAllForZero) {
  int removed = 0;
  EXPECT_NEAR(SurfaceArea(LargestPieces(ThreeBoxes(), 1, &removed).points,
                          LargestPieces(ThreeBoxes(), 1, &removed).faces),
              6, 1e-12);
  EXPECT_EQ(LargestPieces(ThreeBoxes(), 0, &removed).face_count(), 36);
}

TEST(OrientOutward, TurnsOnlyThePiecesThatAreInsideOut) {
  Mesh inside_out = MakeBox(1, 1, 1);
  inside_out.faces.col(1).swap(inside_out.faces.col(2));
  Mesh mesh = Together(inside_out, Shifted(MakeBox(1, 1, 1), 3));
  OrientOutward(mesh);
  const Pieces pieces = FindPieces(mesh);
  EXPECT_NEAR(pieces.list[0].volume, 1, 1e-12);
  EXPECT_NEAR(pieces.list[1].volume, 1, 1e-12);
}

}  // namespace keypose::cleanup::components_test
