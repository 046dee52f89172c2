#include "armature/controller/joint_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/controller/testing/arm.h"
#include "core/values/angles.h"
#include "core/values/errors.h"

namespace keypose::armature::joint_tracker_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Counts that were read at one moment.
void TakeAt(JointTracker& tracker, const std::vector<std::int32_t>& counts, double time_s) {
  tracker.Take(counts, time_s, time_s);
}

BoxInfo Box(int boot, int sensors = 2, CardKind kind = CardKind::kEncoders) {
  return {boot, sensors, {{kind, sensors}}};
}

TEST(JointTracker, CountsBecomeAnglesByTheGearAndItsSign) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1), false);
  TakeAt(tracker, {256, 512}, 0);
  EXPECT_NEAR(tracker.values()[0], 2 * kPi * 512 / (1024 * 25), 1e-15);
  EXPECT_NEAR(tracker.values()[1], -2 * kPi * 256 / (1024 * 10), 1e-15);
  EXPECT_NEAR(tracker.StepOf(0), 0.0140625 * kDegree, 1e-12);
}

TEST(JointTracker, WrapsInBothDirections) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1), false);
  double time = 0;
  std::int64_t truth = 0;
  const auto turn = [&](std::int64_t counts) {
    truth += counts;
    TakeAt(tracker, {static_cast<std::int32_t>(truth & 0xFFFFFF), 0}, time += 1);
    ASSERT_EQ(tracker.states()[1].counts, truth);
    ASSERT_TRUE(tracker.held().empty());
  };
  turn(0);
  for (int i = 0; i < 3000; ++i) turn(-13001);  // twice round downwards
  for (int i = 0; i < 6000; ++i) turn(13007);   // and four times up
}

TEST(JointTracker, JumpIsHeldAndGoesBy) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1), false);
  TakeAt(tracker, {100, 200}, 0);
  TakeAt(tracker, {105, 200 ^ (1 << 20)}, 0.01);
  EXPECT_THAT(tracker.held(), ElementsAre(0));
  EXPECT_EQ(tracker.states()[0].counts, 200);
  EXPECT_EQ(tracker.states()[1].counts, 105);
  TakeAt(tracker, {105, 203}, 0.02);
  EXPECT_TRUE(tracker.held().empty());
  EXPECT_EQ(tracker.states()[0].counts, 203);
}

TEST(JointTracker, FastTurnOfAHandIsNoJump) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1), false);
  TakeAt(tracker, {0, 0}, 0);
  TakeAt(tracker, {200, 0}, 0.01);  // 19.5 revolutions a second
  EXPECT_TRUE(tracker.held().empty());
  TakeAt(tracker, {420, 0}, 0.02);  // 21.5
  EXPECT_THAT(tracker.held(), ElementsAre(1));
}

TEST(JointTracker, StopOfThisProgramMakesNoJump) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1), false);
  // The shaft turns by 10 revolutions a second. The first count is that of 0 s, was answered then,
  // and was heard late.
  tracker.Take({0, 0}, 0, 0.1);
  tracker.Take({1100, 0}, 0.1, 0.101);
  EXPECT_TRUE(tracker.held().empty());
}

TEST(JointTracker, GoesOnOverARestartOfTheHost) {
  const Armature arm = Arm();
  std::vector<SensorState> states(2);
  states[0] = {50000, 0xFFFF00, 1};
  JointTracker tracker(arm, states);
  EXPECT_NEAR(tracker.values()[0], 2 * kPi * 50000 / (1024 * 25), 1e-12);
  tracker.Begin(Box(7), true);
  TakeAt(tracker, {0, 0x000300}, 0);  // moved by 0x400 meanwhile
  EXPECT_EQ(tracker.states()[0].counts, 50000 + 0x400);
}

TEST(JointTracker, AfterAPowerUpItStandsAsItDid) {
  const Armature arm = Arm();
  std::vector<SensorState> states(2);
  states[0] = {50000, 0xFFFF00, 1};
  JointTracker tracker(arm, states);
  tracker.Begin(Box(8), false);
  TakeAt(tracker, {0, 3}, 0);
  EXPECT_EQ(tracker.states()[0].counts, 50003);
}

TEST(JointTracker, AnalogueInputIsQuietAndKnowsItsPlace) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1, 2, CardKind::kAnalogue), false);
  TakeAt(tracker, {0, 30000}, 0);
  tracker.SetValue(0, 0);
  const double before = tracker.values()[0];
  for (const int noise : {30064, 29936, 30064, 30000, 29936, 65535, 30000})
    TakeAt(tracker, {0, noise}, 0.1);
  EXPECT_EQ(tracker.values()[0], before);
  for (int i = 0; i < 5; ++i) TakeAt(tracker, {0, 20000}, 0.2);
  EXPECT_NEAR(tracker.values()[0], 2 * kPi * -10000 / (65536 * 25), 1e-12);
  tracker.Begin(Box(2, 2, CardKind::kAnalogue), false);  // power was lost, the pot turned meanwhile
  for (int i = 0; i < 5; ++i) TakeAt(tracker, {0, 25000}, 0.3);
  EXPECT_NEAR(tracker.values()[0], 2 * kPi * -5000 / (65536 * 25), 1e-12);
}

TEST(JointTracker, NoiseOfAnAnalogueInputIsNoMoveAfterItWasSetToZero) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  tracker.Begin(Box(1, 2, CardKind::kAnalogue), false);
  TakeAt(tracker, {0, 30000}, 0);
  tracker.SetValue(0, 0);
  tracker.Begin(Box(1, 2, CardKind::kAnalogue), false);  // as after a reset of the counters
  TakeAt(tracker, {0, 30064}, 0.1);                      // one step of a converter of ten bits
  EXPECT_EQ(tracker.states()[0].counts, 0);
}

TEST(JointTracker, SensorBeyondTheBoxIsAFault) {
  const Armature arm = Arm();
  JointTracker tracker(arm);
  try {
    tracker.Begin(Box(1, 1), false);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("sensor 1 of 'a' (line 1 of the description) is beyond the "
                                        "controller's 1 sensors"));
  }
}

}  // namespace keypose::armature::joint_tracker_test
