#include "core/surfaces/seams.h"

#include <gtest/gtest.h>

#include <vector>

namespace keypose::seams_test {

/// Two triangles that share an edge whose vertices are doubled: 1 = 3, 2 = 5.
Mesh CutSquare() {
  Mesh mesh;
  mesh.points.resize(6, 3);
  mesh.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0;
  mesh.faces.resize(2, 3);
  mesh.faces << 0, 1, 2, 3, 4, 5;
  return mesh;
}

TEST(FindSeams, JoinsTheTwoSidesOfACut) {
  const Seams seams = FindSeams(CutSquare());
  EXPECT_EQ(seams.joined, 2);
  EXPECT_EQ(seams.one, (std::vector<int>{0, 1, 2, 1, 4, 2}));
}

TEST(FindSeams, WhatTouchesInOnePointOrBackToBackIsNoSeam) {
  Mesh point = CutSquare();
  point.points.row(5) << 2, 2, 0;  // only vertices 1 and 3 stay at one place
  EXPECT_TRUE(FindSeams(point).empty());
  Mesh back = CutSquare();
  back.faces.row(1) << 3, 5, 4;  // runs along the cut in the same direction
  EXPECT_TRUE(FindSeams(back).empty());
}

TEST(FindSeams, AThirdEdgeAtThePlaceMakesItNone) {
  Mesh mesh = CutSquare();
  mesh.points.conservativeResize(9, 3);
  mesh.points.bottomRows(3) << 1, 0, 0, 1, 1, 1, 0, 1, 0;
  mesh.faces.conservativeResize(3, 3);
  mesh.faces.row(2) << 6, 7, 8;
  EXPECT_TRUE(FindSeams(mesh).empty());
}

TEST(Weld, GivesOneSheetAndSaysWhereVerticesWent) {
  const Mesh mesh = CutSquare();
  const WeldedMesh welded = WeldWholeFaces(mesh);
  EXPECT_EQ(welded.mesh.vertex_count(), 4);
  ASSERT_EQ(welded.mesh.face_count(), 2);
  for (int v = 0; v < mesh.vertex_count(); ++v)
    EXPECT_EQ(welded.mesh.points.row(welded.of_input[v]), mesh.points.row(v));
  for (int f = 0; f < 2; ++f)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(welded.mesh.faces(f, k), welded.of_input[mesh.faces(f, k)]);
}

TEST(WeldedFaces, WithoutSeamsAreTheFaces) {
  EXPECT_EQ(WeldedFaces(CutSquare().faces, {}), CutSquare().faces);
}

}  // namespace keypose::seams_test
