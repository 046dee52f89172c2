#include "armature/simulation/simulated_sensors.h"

#include <gtest/gtest.h>

#include "armature/controller/testing/arm.h"
#include "core/values/angles.h"

namespace keypose::armature::simulated_sensors_test {

/// Joint a has sensor 1 and scale 25, joint b sensor 0 and scale -10.
TEST(SimulatedSensors, CountTurnsTimesScaleIn24Bits) {
  const Armature arm = Arm();
  SimulatedSensors sensors(arm);
  sensors.SetValues({2 * kPi, 2 * kPi});
  EXPECT_EQ(sensors.Count(1), 25 * arm.counts_per_revolution);
  EXPECT_EQ(sensors.Count(0), (1 << 24) - 10 * arm.counts_per_revolution);
  sensors.SetValues({0, 0});
  EXPECT_EQ(sensors.Count(1), 0);
  EXPECT_EQ(sensors.Count(0), 0);
}

TEST(SimulatedSensors, GearsScaleTheirJointOnly) {
  const Armature arm = Arm();
  SimulatedSensors plain(arm), geared(arm, {1.1, 1});
  plain.SetValues({kPi, kPi});
  geared.SetValues({kPi, kPi});
  EXPECT_NEAR(geared.Count(1), 1.1 * plain.Count(1), 0.5);
  EXPECT_EQ(geared.Count(0), plain.Count(0));
}

TEST(SimulatedSensors, AStuckOneMissesWhatIsTurnedMeanwhile) {
  const Armature arm = Arm();
  SimulatedSensors sensors(arm);
  sensors.SetValues({1, 0});
  const std::int32_t before = sensors.Count(1);
  sensors.SetStuck(1, true);
  sensors.SetValues({3, 0});
  EXPECT_EQ(sensors.Count(1), before);
  sensors.SetStuck(1, false);
  sensors.SetValues({2, 0});  // back by as much as it had turned before it stuck
  EXPECT_NEAR(sensors.Count(1), 0, 1);
}

TEST(SimulatedSensors, LostPowerIsFlaggedUntilTheCountIsSet) {
  const Armature arm = Arm();
  SimulatedSensors sensors(arm);
  sensors.SetCount(0, 7);
  sensors.SetCount(1, 8);
  EXPECT_EQ(sensors.Flags(1), 0);
  sensors.LosePower(1);
  EXPECT_EQ(sensors.Count(1), 0);
  EXPECT_EQ(sensors.Flags(1), keypose_box::kLostCount);
  EXPECT_EQ(sensors.Count(0), 7);
  EXPECT_EQ(sensors.Flags(0), 0);
}

TEST(SimulatedSensors, AGlitchShowsOtherBitsAndKeepsTheCount) {
  const Armature arm = Arm();
  SimulatedSensors sensors(arm);
  sensors.SetCount(0, 0b1010);
  sensors.SetGlitch(0, 0b0110);
  EXPECT_EQ(sensors.Count(0), 0b1100);
  sensors.SetGlitch(0, 0);
  EXPECT_EQ(sensors.Count(0), 0b1010);
}

}  // namespace keypose::armature::simulated_sensors_test
