#include "reconstruct/surroundings/print_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "reconstruct/testing/known_scenes.h"
#include "reconstruct/testing/printed_mat.h"

namespace keypose::reconstruct::print_turns_test {

using Eigen::Vector2d, Eigen::Vector3d;

constexpr int kViews = 12;

struct Set {
  Scene scene;
  std::vector<Image8> pictures, regions;
  SupportPlane plane;
};

/// The mat from twelve sides, at 25 to 50 degrees above it.
Set MakeSet(bool with_spots) {
  Set set;
  std::mt19937 random(3);
  Camera camera;
  camera.width = 480, camera.height = 360;
  camera.fx = camera.fy = 700, camera.cx = 240, camera.cy = 180;
  for (int k = 0; k < kViews; ++k) {
    const double angle = 2 * kPi * k / kViews, above = (25 + 25 * (k % 2)) * kDegree;
    const Vector3d eye = 4 * Vector3d(std::cos(angle) * std::cos(above),
                                      std::sin(angle) * std::cos(above), std::sin(above));
    const View view = testing::LookFrom(eye, camera, std::to_string(100 + k));
    set.scene.views.push_back(view);
    set.pictures.push_back(testing::MatFrom(view, with_spots, random));
  }
  set.regions.resize(kViews);
  set.plane.normal = Vector3d::UnitZ();
  set.plane.foot = {0.04, -0.03, 0};  // the figure does not stand on the mat's very middle
  set.plane.distance = 4;
  return set;
}

PrintTurns Find(const Set& set) {
  return FindPrintTurns(set.scene, set.pictures, set.regions, set.plane);
}

int Known(const PrintTurns& found) {
  return static_cast<int>(std::count(found.knows.begin(), found.knows.end(), 1));
}

TEST(PrintTurns, RightCamerasAreNotTurned) {
  const PrintTurns found = Find(MakeSet(true));
  EXPECT_EQ(Known(found), kViews);
  EXPECT_EQ(found.turn, std::vector<double>(kViews, 0));
  EXPECT_LT(found.middle.norm(), 0.02);
}

TEST(PrintTurns, CamerasThatATickOrAQuarterTurnedAreTurnedBack) {
  Set set = MakeSet(true);
  const Vector3d middle = Vector3d::Zero();
  std::vector<double> wrong(kViews, 0);
  wrong[2] = wrong[3] = 30 * kDegree, wrong[7] = -10 * kDegree, wrong[9] = kPi / 2;
  const std::vector<View> truth = set.scene.views;
  for (int k = 0; k < kViews; ++k)
    set.scene.views[k] = TurnedWithPrint(truth[k], wrong[k], Vector3d::UnitZ(), middle);
  const PrintTurns found = Find(set);
  for (int k = 0; k < kViews; ++k) {
    EXPECT_NEAR(found.turn[k], -wrong[k], 1 * kDegree) << k;
    const View back =
        TurnedWithPrint(set.scene.views[k], found.turn[k], Vector3d::UnitZ(), found.middle);
    EXPECT_LT((back.Center() - truth[k].Center()).norm(), 0.1) << k;
  }
}

TEST(PrintTurns, AScaleAloneTellsNothing) {
  Set set = MakeSet(false);
  set.scene.views[4] =
      TurnedWithPrint(set.scene.views[4], 30 * kDegree, Vector3d::UnitZ(), Vector3d::Zero());
  const PrintTurns found = Find(set);
  EXPECT_EQ(Known(found), 0);
  EXPECT_EQ(found.turn, std::vector<double>(kViews, 0));
}

TEST(PrintTurns, WhatStandsOnThePrintIsLeftOut) {
  Set set = MakeSet(true);
  // A grey pillar, where its points are: twelve pictures that all have it in the same place.
  for (int k = 0; k < kViews; ++k)
    for (int y = 40; y < 200; ++y)
      for (int x = 205; x < 275; ++x)
        for (int c = 0; c < 3; ++c)
          set.pictures[k].at(x, y)[c] = static_cast<std::uint8_t>(60 + 130 * ((x + y) / 9 % 2));
  for (double height = 0.05; height < 1; height += 0.04)
    for (int side = 0; side < 12; ++side) {
      SparsePoint point =
          testing::PointAt({0.15 * std::cos(side * 0.52), 0.15 * std::sin(side * 0.52), height});
      point.views.clear();
      for (int k = 0; k < kViews; ++k) point.views.push_back(k);
      set.scene.points.push_back(point);
    }
  const PrintTurns found = Find(set);
  EXPECT_EQ(Known(found), kViews);
  EXPECT_EQ(found.turn, std::vector<double>(kViews, 0));
}

TEST(PrintTurns, SameBitsForAnyThreadCount) {
  const Set set = MakeSet(true);
  SetThreadCount(1);
  const PrintTurns one = Find(set);
  SetThreadCount(4);
  const PrintTurns four = Find(set);
  SetThreadCount(0);
  EXPECT_EQ(one.turn, four.turn);
  EXPECT_EQ(one.middle, four.middle);
}

}  // namespace keypose::reconstruct::print_turns_test
