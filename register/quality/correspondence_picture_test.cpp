#include "register/quality/correspondence_picture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/numbers/parallel.h"
#include "core/surfaces/shapes.h"
#include "core/values/errors.h"

namespace keypose::registration::picture_test {

constexpr int kPanel = 64, kGap = 4;

/// Mean difference between two panels of a sheet, at pixels where both show a surface.
double PanelDifference(const Image8& sheet, int row, int a, int b) {
  double sum = 0, count = 0;
  for (int y = 0; y < kPanel; ++y)
    for (int x = 0; x < kPanel; ++x) {
      const std::uint8_t* p = sheet.at(a * (kPanel + kGap) + x, row * (kPanel + kGap) + y);
      const std::uint8_t* q = sheet.at(b * (kPanel + kGap) + x, row * (kPanel + kGap) + y);
      if (p[0] == 246 || q[0] == 246) continue;
      for (int k = 0; k < 3; ++k) sum += std::abs(p[k] - q[k]) / 3.0;
      ++count;
    }
  return count > 0 ? sum / count : 255;
}

Mesh Figure(int levels = 4) {
  Mesh mesh = MakeIcosphere(levels);
  for (int v = 0; v < mesh.vertex_count(); ++v) {
    mesh.points(v, 0) *= 2;
    mesh.points(v, 1) *= 0.7;
  }
  return mesh;
}

TEST(DrawCorrespondence, APerfectResultShowsTheSamePatternThreeTimes) {
  const Mesh mesh = Figure();
  const Image8 sheet = DrawCorrespondence(mesh, mesh.points, mesh, {}, {.panel = kPanel});
  EXPECT_EQ(sheet.width, 4 * kPanel + 3 * kGap);
  EXPECT_EQ(sheet.height, 2 * kPanel + kGap);
  for (int row : {0, 1}) {
    EXPECT_LT(PanelDifference(sheet, row, 0, 1), 0.5);
    EXPECT_LT(PanelDifference(sheet, row, 1, 2), 0.5);
    EXPECT_GT(PanelDifference(sheet, row, 1, 3), 20) << "the error panel has other colours";
  }
}

TEST(DrawCorrespondence, ASlideAlongTheSurfaceIsSeenThoughTheErrorPanelSeesNone) {
  const Mesh mesh = Figure(5);
  // An ellipsoid of revolution, rotated about its long axis. The surface is the same, but the
  // correspondence is not.
  Mesh round = mesh;
  round.points.col(1) /= 0.7;
  PointsX3 slid = round.points;
  const double c = std::cos(0.5), s = std::sin(0.5);
  slid.col(1) = c * round.points.col(1) - s * round.points.col(2);
  slid.col(2) = s * round.points.col(1) + c * round.points.col(2);
  const PictureOptions options{.panel = kPanel, .error_at_red = 0.1};
  const Image8 right = DrawCorrespondence(round, round.points, round, {}, options),
               wrong = DrawCorrespondence(round, slid, round, {}, options);
  // The target's panel changes, because its colours come from the registered mesh.
  double target_changes = 0, error_changes = 0;
  for (int y = 0; y < kPanel; ++y)
    for (int x = 0; x < kPanel; ++x) {
      const auto difference = [&](int panel) {
        const std::uint8_t *p = right.at(panel * (kPanel + kGap) + x, y),
                           *q = wrong.at(panel * (kPanel + kGap) + x, y);
        return std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]);
      };
      target_changes += difference(2);
      error_changes += difference(3);
    }
  EXPECT_GT(target_changes, 20 * error_changes);
}

TEST(DrawCorrespondence, SameBitsAtAnyThreadCountAndWithLandmarks) {
  const Mesh mesh = Figure();
  LandmarkGoal goal;
  goal.source.vertices.setConstant(7);
  goal.target = mesh.points.row(7);
  SetThreadCount(1);
  const Image8 one = DrawCorrespondence(mesh, mesh.points, mesh, {goal}, {.panel = kPanel});
  SetThreadCount(3);
  const Image8 three = DrawCorrespondence(mesh, mesh.points, mesh, {goal}, {.panel = kPanel});
  SetThreadCount(0);
  EXPECT_EQ(one.data, three.data);
  EXPECT_NE(one.data, DrawCorrespondence(mesh, mesh.points, mesh, {}, {.panel = kPanel}).data)
      << "the landmark is drawn";
}

TEST(DrawCorrespondence, BadInputThrows) {
  const Mesh mesh = Figure();
  EXPECT_THROW(DrawCorrespondence(mesh, PointsX3::Zero(3, 3), mesh), InputError);
  EXPECT_THROW(DrawCorrespondence(mesh, mesh.points, mesh, {}, {.panel = 4}), InputError);
  EXPECT_THROW(DrawCorrespondence(mesh, mesh.points, mesh, {}, {.turns_deg = {}}), InputError);
  EXPECT_THROW(DrawCorrespondence(Mesh(), PointsX3(), mesh), InputError);
  EXPECT_FALSE(
      DrawCorrespondence(mesh, PointsX3::Zero(mesh.vertex_count(), 3), mesh, {}, {.panel = kPanel})
          .empty())
      << "a collapse is drawn";
}

}  // namespace keypose::registration::picture_test
