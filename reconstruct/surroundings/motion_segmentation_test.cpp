#include "reconstruct/surroundings/motion_segmentation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>
#include <vector>

#include "core/numbers/parallel.h"
#include "reconstruct/testing/known_scenes.h"

namespace keypose::reconstruct::motion_segmentation_test {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kFigure = 120, kWall = 400;  // points; the wall has far more matches

/// Photographs of a figure on a table that turns before a wall. Feature f is point f in all of
/// them.
struct Room {
  std::vector<Features> features;
  std::vector<PairMatches> matches;
  Scene of_wall, of_figure;  // the cameras in the frame of each
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
    for (int p = 0; p < kFigure + kWall; ++p) {
      const bool turns = p < kFigure || wall_follows;
      const Vector2d x = view.Project(turns ? turn * points[p] : points[p]) +
                         Vector2d(gauss(random), gauss(random));
      features.positions.row(p) = x.transpose().cast<float>();
    }
    room.features.push_back(features);
    room.of_wall.views.push_back(view);
    View turned = view;
    turned.camera_from_world.rotation = view.camera_from_world.rotation * Eigen::Quaterniond(turn);
    room.of_figure.views.push_back(turned);
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

std::vector<int> AllPlaced(const Room& room) {
  std::vector<int> view_of_image(room.features.size());
  std::iota(view_of_image.begin(), view_of_image.end(), 0);
  return view_of_image;
}

/// Features from `begin` to `end` with such a vote.
int Count(const MotionVotes& votes, int begin, int end, int sign) {
  int count = 0;
  for (const std::vector<int>& of_image : votes)
    for (int f = begin; f < end; ++f) count += sign * of_image[f] > 0;
  return count;
}

TEST(MotionSegmentation, BeforeATripodTheWallStays) {
  const Room room = MakeRoom(6, 12, 0, false);
  std::vector<ImagePair> pairs;
  const MotionVotes votes = TurnsBeforeTripod(room.features, room.matches, 1200, {}, &pairs);
  EXPECT_EQ(pairs.size(), 15U);  // also those that share only the wall
  // Points at the table's axis hardly move, and some of the figure's match by chance in place.
  EXPECT_LE(Count(votes, 0, kFigure, -1), 6 * kFigure / 50);
  EXPECT_GE(Count(votes, 0, kFigure, 1), 6 * kFigure * 8 / 10);
  EXPECT_GE(Count(votes, kFigure, kFigure + kWall, -1), 6 * kWall * 98 / 100);
}

TEST(MotionSegmentation, InTheHandNothingStays) {
  const Room room = MakeRoom(6, 12, 0.25, false);
  std::vector<ImagePair> pairs;
  const MotionVotes votes = TurnsBeforeTripod(room.features, room.matches, 1200, {}, &pairs);
  EXPECT_TRUE(pairs.empty());
  EXPECT_EQ(Count(votes, 0, kFigure + kWall, 1), 0);
}

// A photograph that was taken twice shows the figure in place as well.
TEST(MotionSegmentation, PhotographsTakenTwiceAreNotBeforeATurningTable) {
  const Room room = MakeRoom(6, 0, 0, false);
  std::vector<ImagePair> pairs;
  TurnsBeforeTripod(room.features, room.matches, 1200, {}, &pairs);
  EXPECT_TRUE(pairs.empty());
}

TEST(MotionSegmentation, TheFigureDoesNotFitTheWallsCameras) {
  const Room room = MakeRoom(6, 12, 0.25, false);
  const MotionVotes votes =
      MovesOtherwise(room.features, room.matches, room.of_wall, AllPlaced(room), {});
  EXPECT_GE(Count(votes, 0, kFigure, 1), 6 * kFigure / 2);
  // Some move along the wall's epipolar lines by chance.
  EXPECT_LE(Count(votes, 0, kFigure, -1), 6 * kFigure / 5);
  EXPECT_EQ(Count(votes, kFigure, kFigure + kWall, 1), 0);
  EXPECT_GE(Count(votes, kFigure, kFigure + kWall, -1), 6 * kWall * 98 / 100);
}

TEST(MotionSegmentation, WhereTheCameraWalksAllFits) {
  const Room room = MakeRoom(6, 12, 0.25, true);
  const MotionVotes votes =
      MovesOtherwise(room.features, room.matches, room.of_figure, AllPlaced(room), {});
  EXPECT_EQ(Count(votes, 0, kFigure + kWall, 1), 0);
}

TEST(MotionSegmentation, ARegionHoldsWhatMostNeighboursSay) {
  // A grid of features; those in the left third turn, but one in ten errs.
  Features features;
  features.positions.resize(1200, 2);
  features.scales = Eigen::VectorXf::Constant(1200, 2);
  std::vector<int> votes(1200);
  for (int f = 0; f < 1200; ++f) {
    const int x = f % 40, y = f / 40;
    features.positions.row(f) << 30.0F * static_cast<float>(x), 30.0F * static_cast<float>(y);
    votes[f] = ((x < 13) != (f % 10 == 7)) ? 2 : -1;
  }
  Camera lens;
  lens.width = 1200, lens.height = 900;
  const auto regions = MotionRegions({features}, {votes}, {lens}, {});
  ASSERT_EQ(regions.size(), 1U);
  const Image8& region = regions[0];
  int wrong = 0;
  for (int y = 0; y < region.height; ++y)
    for (int x = 0; x < region.width; ++x) {
      const double at = (x + 0.5) * lens.width / region.width;
      if (std::abs(at - 375) < 45) continue;  // at the border
      wrong += (*region.at(x, y) > 127) != (at < 375);
    }
  EXPECT_LE(wrong, region.width * region.height / 100);
  // Of 390 features on the left 39 err; a few of the others stand beside the border.
  EXPECT_NEAR(CountInRegions({features}, {votes}, {lens}, regions)[0], 351, 15);
  // Hardly any votes say nothing.
  EXPECT_TRUE(MotionRegions({features}, {std::vector<int>(1200, 0)}, {lens}, {})[0].empty());
}

TEST(MotionSegmentation, TurnsOfCameras) {
  const Room room = MakeRoom(2, 30, 0, false);
  EXPECT_NEAR(MeanTurn(room.of_wall.views), 0, 1e-9);
  EXPECT_NEAR(MeanTurn(room.of_figure.views), 3.14159265358979 / 6, 1e-9);
}

TEST(MotionSegmentation, SameResultForAnyThreadCount) {
  const Room room = MakeRoom(5, 12, 0.25, false);
  const auto votes = [&](int threads) {
    SetThreadCount(threads);
    return MovesOtherwise(room.features, room.matches, room.of_wall, AllPlaced(room), {});
  };
  const MotionVotes one = votes(1), four = votes(4);
  SetThreadCount(0);
  EXPECT_EQ(one, four);
}

}  // namespace keypose::reconstruct::motion_segmentation_test
