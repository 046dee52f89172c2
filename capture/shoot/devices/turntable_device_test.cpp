#include "capture/shoot/devices/turntable_device.h"

#include <gtest/gtest.h>

namespace keypose::capture::shoot::turntable_device_test {

TEST(NearestTurn, TakesTheShorterWayAndForwardsForHalfATurn) {
  EXPECT_DOUBLE_EQ(NearestTurn(345, 0), 360);
  EXPECT_DOUBLE_EQ(NearestTurn(720, 345), 705);
  EXPECT_DOUBLE_EQ(NearestTurn(0, 180), 180);
  EXPECT_DOUBLE_EQ(NearestTurn(-15, 15), 15);
}

}  // namespace keypose::capture::shoot::turntable_device_test
