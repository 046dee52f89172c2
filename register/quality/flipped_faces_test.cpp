#include "register/quality/flipped_faces.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>

#include "core/surfaces/shapes.h"

namespace keypose::registration::flipped_faces_test {

TEST(TargetFaces, OnlyAFaceThatIsTurnedOverOpposes) {
  const Mesh ball = MakeIcosphere(3);
  const TargetFaces target(ball.points, ball.faces);
  FacesX3 faces = ball.faces;
  std::swap(faces(7, 1), faces(7, 2));
  for (const double slack : {0.0, 0.02}) {
    const std::vector<char> opposed = target.Opposed(ball.points, faces, slack);
    EXPECT_EQ(std::count(opposed.begin(), opposed.end(), 1), 1) << slack;
    EXPECT_EQ(opposed[7], 1) << slack;
  }
}

TEST(TargetFaces, BetweenTwoWallsTheSlackDecides) {
  // Two squares face each other across a gap of 0.1; the face in between is nearer to the wrong
  // one.
  Mesh walls;
  walls.points.resize(6, 3);
  walls.points << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0.1, 1, 0, 0.1, 0, 1, 0.1;
  walls.faces.resize(2, 3);
  walls.faces << 0, 1, 2, 3, 5, 4;
  const TargetFaces target(walls.points, walls.faces);
  PointsX3 between = walls.points.topRows(3);
  between.col(2).setConstant(0.06);
  FacesX3 up(1, 3);
  up << 0, 1, 2;
  EXPECT_EQ(target.Opposed(between, up, 0)[0], 1);
  EXPECT_EQ(target.Opposed(between, up, 0.05)[0], 0);
}

}  // namespace keypose::registration::flipped_faces_test
