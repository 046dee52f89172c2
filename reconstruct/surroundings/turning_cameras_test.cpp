#include "reconstruct/surroundings/turning_cameras.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "core/numbers/parallel.h"
#include "core/values/angles.h"
#include "reconstruct/surroundings/testing/cameras_over_plane.h"
#include "reconstruct/testing/printed_mat.h"

namespace keypose::reconstruct::turning_cameras_test {

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

/// Drawn once.
const Turned& TurnedMat() {
  static const Turned set = MakeTurned();
  return set;
}

TEST(CamerasOverTurningPrint, AreRightWhereEveryMatchIsAtAWrongTurn) {
  const Turned& set = TurnedMat();
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
  Turned set = TurnedMat();
  set.pairs.clear();
  EXPECT_FALSE(CamerasOverTurningPrint(set.Set(), set.pictures, set.regions));
}

}  // namespace keypose::reconstruct::turning_cameras_test
