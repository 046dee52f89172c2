// Planes that turn before a tripod, from matches at wrong turns.
#include "reconstruct/surroundings/turning_plane.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "reconstruct/surroundings/turning_cameras.h"
#include "reconstruct/testing/known_scenes.h"
#include "reconstruct/testing/printed_mat.h"

namespace keypose::reconstruct::turning_plane_test {

using Eigen::Vector2d, Eigen::Vector3d;

/// From directions in a camera's frame to the plane z = 0 of the world, homogeneous.
Eigen::Matrix3d PlaneFromDirections(const Rigid3& camera_from_world) {
  const Eigen::Matrix3d rotation = camera_from_world.rotation.toRotationMatrix();
  Eigen::Matrix3d directions;
  directions << rotation.col(0), rotation.col(1), camera_from_world.translation;
  return directions.inverse();
}

/// Of directions, when the plane turns round the world's z axis.
Eigen::Matrix3d TurnSeenBy(const View& view, double turn) {
  const Eigen::Matrix3d plane = PlaneFromDirections(view.camera_from_world);
  return plane.inverse() * Eigen::AngleAxisd(turn, Vector3d::UnitZ()).toRotationMatrix() * plane;
}

Camera Lens() {
  Camera camera;
  camera.width = 480, camera.height = 360;
  camera.fx = camera.fy = 700, camera.cx = 240, camera.cy = 180;
  return camera;
}

/// Of one tripod, so far from the mat, when the mat is turned.
View From(double distance, double above, double turn, const std::string& name) {
  return testing::LookFrom(distance * Vector3d(std::cos(turn) * std::cos(above),
                                               std::sin(turn) * std::cos(above), std::sin(above)),
                           Lens(), name);
}

TEST(PlaneOfTurn, IsToldByAnyTurn) {
  const View view = From(4, 30 * kDegree, 0.3, "a");
  for (const double degrees : {-150.0, -40.0, 20.0, 90.0, 170.0}) {
    const auto plane = PlaneOfTurn(-2.5 * TurnSeenBy(view, degrees * kDegree));
    ASSERT_TRUE(plane) << degrees;
    const Rigid3& pose = view.camera_from_world;
    EXPECT_LT((plane->middle - pose.translation.normalized()).norm(), 1e-9) << degrees;
    EXPECT_LT((plane->normal - pose.rotation * Vector3d::UnitZ()).norm(), 1e-9) << degrees;
    EXPECT_NEAR(*RadiusOnPlane(*plane, pose * Vector3d(0.3, 0.4, 0)), 0.5 / 4, 1e-9);
  }
}

TEST(PlaneOfTurn, OtherMotionsAreNone) {
  const View view = From(4, 30 * kDegree, 0.3, "a");
  EXPECT_FALSE(PlaneOfTurn(Eigen::Matrix3d::Identity()));
  EXPECT_FALSE(PlaneOfTurn(Eigen::Matrix3d::Zero()));
  EXPECT_FALSE(PlaneOfTurn(TurnSeenBy(view, 1 * kDegree))) << "hardly turned";
  const Eigen::Matrix3d plane = PlaneFromDirections(view.camera_from_world);
  Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
  shear(0, 1) = 0.8, shear(1, 0) = -0.1, shear(0, 2) = 0.3;
  EXPECT_FALSE(PlaneOfTurn(plane.inverse() * shear * plane)) << "no turn of the plane";
}

TEST(CameraOver, SeesThePlaneSo) {
  const View view = From(4, 30 * kDegree, 0, "a");
  const auto plane = PlaneOfTurn(TurnSeenBy(view, 1));
  ASSERT_TRUE(plane);
  const Rigid3 over = CameraOver(*plane, 4);
  EXPECT_LT((over.translation - view.camera_from_world.translation).norm(), 1e-9);
  EXPECT_LT(over.rotation.angularDistance(view.camera_from_world.rotation), 1e-9);
}

/// A mat that turned before two tripods, in photographs that match by its scale at wrong turns.
struct Turned {
  std::vector<View> truth;
  std::vector<Image8> pictures, regions;
  std::vector<std::string> names;
  std::vector<Camera> lenses;
  std::vector<Features> features;
  std::vector<PairMatches> matches;
  std::vector<ImagePair> pairs;
  BeforeTripods Set() const { return {names, lenses, features, matches, pairs}; }
};

constexpr int kTicks = 36, kOfTripod = 6;

/// The ticks' outer and inner ends.
Features TicksFrom(const View& view, std::mt19937& random) {
  std::normal_distribution<float> noise(0, 0.3F);
  Features features;
  features.positions.resize(2 * kTicks, 2);
  features.scales.setOnes(2 * kTicks);
  for (int t = 0; t < 2 * kTicks; ++t) {
    const double angle = 2 * kPi * (t % kTicks) / kTicks, radius = t < kTicks ? 0.82 : 0.92;
    const Vector2d pixel = view.Project(radius * Vector3d(std::cos(angle), std::sin(angle), 0));
    features.positions(t, 0) = static_cast<float>(pixel.x()) + noise(random);
    features.positions(t, 1) = static_cast<float>(pixel.y()) + noise(random);
  }
  return features;
}

Turned MakeTurned() {
  Turned set;
  std::mt19937 random(7);
  for (int i = 0; i < 2 * kOfTripod; ++i) {
    const bool second = i >= kOfTripod;
    const double turn = (53 * (i % kOfTripod) + (second ? 17 : 0)) * kDegree;
    set.names.push_back(std::to_string(100 + i));
    set.truth.push_back(From(second ? 5 : 4, (second ? 48 : 28) * kDegree, turn, set.names.back()));
    set.pictures.push_back(testing::MatFrom(set.truth.back(), true, random));
    set.lenses.push_back(Lens());
    set.features.push_back(TicksFrom(set.truth.back(), random));
  }
  set.regions.resize(set.truth.size());
  std::uniform_int_distribution<int> any(0, kTicks - 1);
  for (int i = 0; i < 2 * kOfTripod; ++i)
    for (int j = i + 1; j < 2 * kOfTripod; ++j) {
      const int shift = any(random);
      PairMatches pair{i, j, {}};
      for (int t = 0; t < 2 * kTicks; ++t)
        pair.features.emplace_back(t, t / kTicks * kTicks + (t + shift) % kTicks);
      set.matches.push_back(pair);
      if (i / kOfTripod == j / kOfTripod) set.pairs.emplace_back(i, j);
    }
  return set;
}

TEST(CamerasOverTurningPrint, AreRightWhereEveryMatchIsAtAWrongTurn) {
  const Turned set = MakeTurned();
  SetThreadCount(1);
  const auto found = CamerasOverTurningPrint(set.Set(), set.pictures, set.regions);
  SetThreadCount(4);
  const auto again = CamerasOverTurningPrint(set.Set(), set.pictures, set.regions);
  SetThreadCount(0);
  ASSERT_TRUE(found && again);
  EXPECT_EQ(found->tripods, 2);
  const std::vector<View>& views = found->scene.views;
  ASSERT_GE(views.size(), set.truth.size() - 1);
  ASSERT_EQ(again->scene.views.size(), views.size());
  const auto truth_of = [&](const View& view) -> const View& {
    return *std::find_if(set.truth.begin(), set.truth.end(),
                         [&](const View& truth) { return truth.name == view.name; });
  };
  // The turn between two cameras does not depend on how the world is turned.
  const auto turn = [](const View& a, const View& b) {
    return a.camera_from_world.rotation.angularDistance(b.camera_from_world.rotation);
  };
  const auto apart = [](const View& a, const View& b) { return (a.Center() - b.Center()).norm(); };
  const double scale = truth_of(views[0]).Center().norm() / views[0].Center().norm();
  for (std::size_t i = 1; i < views.size(); ++i) {
    const View &truth = truth_of(views[i]), &first = truth_of(views[0]);
    EXPECT_NEAR(turn(views[i], views[0]), turn(truth, first), 1.5 * kDegree) << i;
    EXPECT_NEAR(scale * apart(views[i], views[0]), apart(truth, first), 0.04 * 4) << i;
    EXPECT_EQ(again->scene.views[i].Center(), views[i].Center()) << "for any thread count";
  }
}

TEST(CamerasOverTurningPrint, NoneWithoutTripods) {
  Turned set = MakeTurned();
  set.pairs.clear();
  EXPECT_FALSE(CamerasOverTurningPrint(set.Set(), set.pictures, set.regions));
}

}  // namespace keypose::reconstruct::turning_plane_test
