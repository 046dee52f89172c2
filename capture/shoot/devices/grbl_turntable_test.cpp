#include "capture/shoot/devices/grbl_turntable.h"

#include <gtest/gtest.h>

namespace keypose::capture::shoot::grbl_turntable_test {

TEST(GrblStatus, IsReadFromReportsOfBothKinds) {
  GrblStatus status;
  ASSERT_TRUE(
      ParseGrblStatus("<Hold:0|MPos:1.5,-2.250,3.000|FS:0,0|WCO:0.5,1.000,0>", 'Y', &status));
  EXPECT_EQ(status.state, "Hold");
  EXPECT_DOUBLE_EQ(status.machine_position, -2.25);
  EXPECT_DOUBLE_EQ(status.offset, 1);
  ASSERT_TRUE(ParseGrblStatus("<Idle|WPos:7.000,0,0|Bf:15,128>", 'X', &status));
  EXPECT_DOUBLE_EQ(status.work_position, 7);
}

TEST(GrblStatus, OfADamagedLineIsRefused) {
  GrblStatus status;
  for (const char* text :
       {"", "ok", "<>", "<Idle", "<Idle|MPos:x,0,0>", "<Idle|MPos:nan,0,0>", ">Idle<"})
    EXPECT_FALSE(ParseGrblStatus(text, 'X', &status)) << text;
}

}  // namespace keypose::capture::shoot::grbl_turntable_test
