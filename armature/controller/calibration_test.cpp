#include "armature/controller/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "armature/controller/joint_tracker.h"
#include "armature/controller/testing/arm.h"
#include "core/values/errors.h"

namespace keypose::armature::calibration_test {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(Calibration, IsReadAsWritten) {
  const Armature arm = Arm();
  const Calibration made{9, {{-70000000000, 0xFFFFFF, 1.004}, {3, 2, 1}}};
  const Calibration read = ParseCalibration(CalibrationText(arm, made), "c.json", arm);
  EXPECT_EQ(read.boot, 9);
  EXPECT_EQ(read.sensors[0].counts, -70000000000);
  EXPECT_EQ(read.sensors[0].raw, 0xFFFFFF);
  EXPECT_EQ(read.sensors[0].gear, 1.004);
  EXPECT_EQ(read.sensors[1].counts, 3);
}

TEST(Calibration, OfAnotherDescriptionIsAFault) {
  const Armature arm = Arm();
  Armature other = arm;
  other.nodes[1].name = "c";
  const std::string text = CalibrationText(other, {9, std::vector<SensorState>(2)});
  try {
    ParseCalibration(text, "c.json", arm);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("c.json: it has no joint 'b' with sensor 0"));
  }
  std::vector<std::string> fresh;
  Calibration made{9, {{500, 400, 1.004}, {3, 2, 1.01}}};
  made = FittingCalibration(CalibrationText(other, made), "c.json", arm, &fresh);
  EXPECT_THAT(fresh, ElementsAre("b"));
  EXPECT_EQ(made.boot, 9);
  EXPECT_EQ(made.sensors[0].gear, 1.004);
  EXPECT_EQ(made.sensors[1].gear, 1);
  EXPECT_THROW(ParseCalibration("{}", "c.json", arm), InputError);
  EXPECT_THROW(ParseCalibration("[1", "c.json", arm), InputError);
  EXPECT_THROW(ParseCalibration(std::string(150, '['), "c.json", arm), InputError);
}

}  // namespace keypose::armature::calibration_test
