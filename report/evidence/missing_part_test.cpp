// A ball with an arm: masks show both, the mesh lacks the arm.
#include "report/evidence/missing_part.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/numbers/parallel.h"
#include "core/pictures/fit_view.h"
#include "core/surfaces/shapes.h"
#include "report/evidence/view_evidence.h"

namespace keypose::report::missing_part_test {

using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::UnorderedElementsAre;

constexpr int kViews = 10;

Mesh Ball() { return MakeIcosphere(3); }

Mesh Arm() {
  Mesh arm = MakeIcosphere(3);
  arm.points *= 0.3;
  arm.points.col(0).array() += 1.6;
  return arm;
}

Mesh Joined(const Mesh& a, const Mesh& b) {
  Mesh both;
  both.points.resize(a.points.rows() + b.points.rows(), 3);
  both.points << a.points, b.points;
  both.faces.resize(a.faces.rows() + b.faces.rows(), 3);
  both.faces << a.faces, b.faces.array() + static_cast<int>(a.points.rows());
  return both;
}

Image8 SeenOf(const Mesh& mesh, const View& view) {
  return Covered(mesh, RayScene(mesh.points, mesh.faces), view);
}

/// @param armless  views whose masks leave the arm out
std::vector<CoveredMask> Round(const Mesh& mesh, const std::vector<int>& armless = {}) {
  const Mesh figure = Joined(Ball(), Arm());
  std::vector<CoveredMask> views;
  for (int v = 0; v < kViews; ++v) {
    View view = FitView(figure.points, 360.0 * v / kViews, 15, 240, 200);
    view.name = std::to_string(v);
    const bool without = std::find(armless.begin(), armless.end(), v) != armless.end();
    views.push_back({view, SeenOf(without ? Ball() : figure, view), SeenOf(mesh, view)});
  }
  return views;
}

TEST(FindMissingPart, NamesTheMasksThatLeaveItOut) {
  const Mesh ball = Ball();
  const MissingPart part = FindMissingPart(Round(ball, {1, 6}), ball.points);
  EXPECT_THAT(part.left_out_by, UnorderedElementsAre("1", "6"));
  EXPECT_GT(part.shown_by.size(), 3u);
  EXPECT_THAT(part.shown_by, Not(::testing::Contains("1")));
  EXPECT_GT(part.largest, 0.06);
  EXPECT_LT(part.largest, 0.13);  // the disc of the arm is 0.083 of both, and nearer than the ball
}

TEST(FindMissingPart, MasksThatAllShowItLeaveNothingOut) {
  const Mesh ball = Ball();
  const MissingPart part = FindMissingPart(Round(ball), ball.points);
  EXPECT_THAT(part.shown_by, Not(IsEmpty()));
  EXPECT_THAT(part.left_out_by, IsEmpty());
}

TEST(FindMissingPart, AThinRimIsNoPart) {
  Mesh figure = Joined(Ball(), Arm());
  figure.points *= 0.99;
  EXPECT_THAT(FindMissingPart(Round(figure), figure.points).shown_by, IsEmpty());
}

TEST(FindMissingPart, OneMaskAloneMayBeWrong) {
  const Mesh ball = Ball();
  EXPECT_THAT(FindMissingPart(Round(ball, {0, 1, 2, 4, 5, 6, 7, 8, 9}), ball.points).shown_by,
              IsEmpty());
}

TEST(FindMissingPart, HasTheSameBitsForAnyThreadCount) {
  const Mesh ball = Ball();
  const std::vector<CoveredMask> views = Round(ball, {1, 6});
  SetThreadCount(1);
  const MissingPart one = FindMissingPart(views, ball.points);
  SetThreadCount(4);
  const MissingPart four = FindMissingPart(views, ball.points);
  SetThreadCount(0);
  EXPECT_EQ(one.shown_by, four.shown_by);
  EXPECT_EQ(one.left_out_by, four.left_out_by);
  EXPECT_EQ(one.largest, four.largest);
}

}  // namespace keypose::report::missing_part_test
