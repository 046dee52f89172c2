#include "synth/worlds/pose_between.h"

#include <gtest/gtest.h>

#include "synth/worlds/world.h"

namespace keypose::synth::pose_between_test {

World SmallWorld() {
  WorldOptions options;
  options.spacing_m = 0.006;
  return MakeWorld(options);
}

TEST(PoseBetween, EndsAreTheGivenPosesAndTheMiddleLiesBetween) {
  const World world = SmallWorld();
  for (const char* other : {"bow", "bent"}) {
    const Pose &wave = world.PoseNamed("wave"), &end = world.PoseNamed(other);
    const PointsX3 a = wave(world.rest.points), b = end(world.rest.points);
    EXPECT_EQ(PoseBetween(wave, end, 0)(world.rest.points), a);
    EXPECT_EQ(PoseBetween(wave, end, 1)(world.rest.points), b);
    // Nothing jumps at the ends and in the middle, although `bent` has its steps in another order.
    const auto at = [&](double share) { return PoseBetween(wave, end, share)(world.rest.points); };
    EXPECT_LT((at(1 - 1e-7) - b).rowwise().norm().maxCoeff(), 1e-5) << other;
    EXPECT_LT((at(1e-7) - a).rowwise().norm().maxCoeff(), 1e-5) << other;
    EXPECT_LT((at(0.5 + 1e-7) - at(0.5 - 1e-7)).rowwise().norm().maxCoeff(), 1e-5) << other;
    EXPECT_GT((at(0.5) - a).rowwise().norm().maxCoeff(), 0.005);
  }
}

}  // namespace keypose::synth::pose_between_test
