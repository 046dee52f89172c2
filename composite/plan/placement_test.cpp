#include "composite/plan/placement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace keypose::composite::placement_test {

/// A body, and an arm of a third of the vertices that swings about the body's corner.
PointsX3 BodyWithArm(double swing_rad) {
  PointsX3 points(90, 3);
  for (int i = 0; i < 60; ++i)
    points.row(i) << std::sin(1.0 * i), std::cos(1.7 * i), 0.5 + 0.5 * std::sin(2.3 * i);
  const Eigen::AngleAxisd swing(swing_rad, Eigen::Vector3d::UnitY());
  for (int i = 60; i < 90; ++i) {
    const Eigen::Vector3d x(0.05 * (i - 60), 0.02 * std::sin(i), 0.02 * std::cos(i));
    points.row(i) = (Eigen::Vector3d(1, 0, 0.5) + swing * x).transpose();
  }
  return points;
}

TEST(CommonMotion, ALimbDoesNotPullTheBody) {
  const Similarity3 moved{
      1, Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.2, -0.1, 0}};
  const PointsX3 a = BodyWithArm(0), b = Transformed(moved, BodyWithArm(1.2));
  const CommonMotion motion = FindCommonMotion(a, b);
  EXPECT_LT((motion.b_from_a.translation - moved.translation).norm(), 1e-3);
  EXPECT_LT(motion.weights.tail(20).maxCoeff(), 0.05);
  EXPECT_GT(motion.weights.head(60).minCoeff(), 0.5);
}

TEST(PlacementBetween, WhatStandsStillStandsStill) {
  // The shapes come in coordinates of their own, turned and scaled, as reconstructions do.
  const PointsX3 a = BodyWithArm(0), b = BodyWithArm(1.2), middle = BodyWithArm(0.6);
  const Similarity3 odd{
      0.5,
      Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix(),
      {3, 2, 1}};
  const PointsX3 placed = PlacementBetween(a, b).Place(Transformed(odd, middle), 2, 0.5);
  EXPECT_LT((placed - middle).rowwise().norm().maxCoeff(), 2e-3);
}

TEST(PlacementBetween, EndsAreTheLocatedPlaces) {
  const Similarity3 moved{
      1, Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix(), {0.2, -0.1, 0}};
  const PointsX3 a = BodyWithArm(0), b = Transformed(moved, BodyWithArm(1.2));
  const PlacementBetween between(a, b);
  EXPECT_LT((between.Place(BodyWithArm(0), 1, 0) - a).rowwise().norm().maxCoeff(), 1e-9);
  EXPECT_LT((between.Place(BodyWithArm(1.2), 1, 1) - b).rowwise().norm().maxCoeff(), 1e-9);
}

}  // namespace keypose::composite::placement_test
