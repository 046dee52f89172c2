#include "reconstruct/surroundings/figure_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "core/parallel.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFigure = 120, kWall = 400;  // points; the wall has far more matches

/// Photographs of a figure on a table that turns before a wall. Feature f is point f in all of
/// them.
struct Room {
  std::vector<Features> features;
  std::vector<PairMatches> matches;
  std::vector<Eigen::VectorXf> likely;
};

/// @param turn_deg  of the table from one photograph to the next
/// @param sway      of the camera in the hand, in units of its distance of 4
/// @param wall_follows  all moves as one: the camera walks
Room MakeRoom(int photographs, double turn_deg, double sway, bool wall_follows) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(-1, 1);
  std::normal_distribution<double> gauss(0, 0.3);
  std::vector<Vector3d> points;
  for (int p = 0; p < kFigure; ++p)
    points.emplace_back(0.8 * unit(random), 0.8 * unit(random), 0.8 * unit(random));
  for (int p = 0; p < kWall; ++p)
    points.emplace_back(2.5 * unit(random), 3 + 0.5 * unit(random), 2 * unit(random));
  Camera camera;
  camera.width = 1200, camera.height = 900;
  camera.fx = camera.fy = 1200, camera.cx = 600, camera.cy = 450;
  Room room;
  for (int i = 0; i < photographs; ++i) {
    const Vector3d eye(sway * unit(random), -4 + sway * unit(random), 1 + sway * unit(random));
    const View view = testing::LookFrom(eye, camera, "");
    const Eigen::AngleAxisd turn(turn_deg * i * 3.14159265358979 / 180, Vector3d::UnitZ());
    Features features;
    features.positions.resize(kFigure + kWall, 2);
    features.scales = Eigen::VectorXf::Constant(kFigure + kWall, 2);
    Eigen::VectorXf likely = Eigen::VectorXf::Constant(kFigure + kWall, 0.05F);
    for (int p = 0; p < kFigure + kWall; ++p) {
      const bool turns = p < kFigure || wall_follows;
      const Vector2d x = view.Project(turns ? turn * points[p] : points[p]) +
                         Vector2d(gauss(random), gauss(random));
      features.positions.row(p) = x.transpose().cast<float>();
      if (p < kFigure) likely(p) = 0.8F;
    }
    room.features.push_back(features);
    room.likely.push_back(likely);
  }
  for (int i = 0; i < photographs; ++i)
    for (int j = i + 1; j < photographs; ++j) {
      PairMatches pair{i, j, {}};
      // Figures turn away: photographs far apart share the wall only.
      for (std::uint32_t p = j - i > 2 ? kFigure : 0; p < kFigure + kWall; ++p)
        pair.features.emplace_back(p, p);
      room.matches.push_back(pair);
    }
  return room;
}

FigureMotion Follow(const Room& room) {
  return FollowFigure(room.features, room.matches, room.likely, 1200, {});
}

int Left(const FigureMotion& motion, int begin, int end) {
  int count = 0;
  for (const std::vector<char>& left : motion.left_behind)
    count += static_cast<int>(std::count(left.begin() + begin, left.begin() + end, 1));
  return count;
}

TEST(FollowFigure, WallBehindATripodsTurntableIsLeftBehind) {
  const Room room = MakeRoom(6, 12, 0, false);
  const FigureMotion motion = Follow(room);
  // Points at the table's axis hardly move.
  EXPECT_LE(Left(motion, 0, kFigure), 6 * kFigure / 50);
  EXPECT_GE(Left(motion, kFigure, kFigure + kWall), 6 * kWall * 98 / 100);
}

// Seen from the hand the wall moves too, rigidly, with three times the figure's matches, and in
// pairs far apart it is all that is shared.
TEST(FollowFigure, WallBehindATurntableSeenFromTheHandIsLeftBehind) {
  const Room room = MakeRoom(6, 12, 0.25, false);
  const FigureMotion motion = Follow(room);
  // Figures' points along the wall's epipolar lines fit both motions.
  EXPECT_LE(Left(motion, 0, kFigure), 6 * kFigure * 15 / 100);
  EXPECT_GE(Left(motion, kFigure, kFigure + kWall), 6 * kWall * 9 / 10);
}

TEST(FollowFigure, NothingIsLeftBehindWhereTheCameraWalks) {
  const FigureMotion motion = Follow(MakeRoom(6, 12, 0.25, true));
  EXPECT_EQ(motion.features_left, 0);
}

TEST(FollowFigure, SameResultForAnyThreadCount) {
  const Room room = MakeRoom(5, 12, 0.25, false);
  SetThreadCount(1);
  const FigureMotion one = Follow(room);
  SetThreadCount(4);
  const FigureMotion four = Follow(room);
  SetThreadCount(0);
  EXPECT_EQ(one.left_behind, four.left_behind);
}

}  // namespace
}  // namespace keypose::reconstruct
