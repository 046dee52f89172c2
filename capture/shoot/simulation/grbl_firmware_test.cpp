#include <gtest/gtest.h>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/grbl_turntable.h"
#include "capture/shoot/simulation/turntable_bench.h"

namespace keypose::capture::shoot::grbl_firmware_test {

constexpr double kClose_deg = 0.01;

GrblTimes FastGrbl() {
  GrblTimes times;
  times.wake_up_s = 0.2, times.reply_s = 0.2, times.ask_s = 0.005, times.stall_s = 0.2;
  return times;
}

struct GrblBench : TurntableBench {
  explicit GrblBench(const std::string& planned = "", const GrblHabits& habits = {})
      : TurntableBench(MakeGrblFirmware(habits), planned),
        table(MakeGrblTurntable(folder / "port", {.speed_deg_s = FirmwareOptions{}.speed_deg_s},
                                FastGrbl())) {}
  std::unique_ptr<TurntableDevice> table;
};

TEST(GrblTurntable, StandsWhereItWasToldToAllRoundTheCircle) {
  GrblBench bench;
  bench.table->Connect(0, false, "", bench.patience);
  for (int i = 0; i <= 24; ++i) {
    bench.table->TurnTo(15.0 * (i % 24), bench.patience);
    EXPECT_LT(bench.Off(15.0 * i), kClose_deg) << i;
  }
  EXPECT_NEAR(bench.world.table_deg(), 360, kClose_deg);
}

TEST(GrblTurntable, KeepsTheAngleThatItHadBeforeTheProgramStarted) {
  GrblBench bench;
  bench.world.SetTable(330);
  bench.table->Connect(330, false, "", bench.patience);
  bench.table->TurnTo(15, bench.patience);
  EXPECT_NEAR(bench.world.table_deg(), 375, kClose_deg);
}

class GrblFaults : public ::testing::TestWithParam<const char*> {};

TEST_P(GrblFaults, TurnTheTableOnceAndOnlyOnce) {
  GrblBench bench(std::string(GetParam()) + "@2");
  bench.table->Connect(0, false, "", bench.patience);
  for (const double angle_deg : {30, 60, 90}) {
    bench.table->TurnTo(angle_deg, bench.patience);
    EXPECT_LT(bench.Off(angle_deg), kClose_deg);
  }
}

INSTANTIATE_TEST_SUITE_P(Protocol, GrblFaults,
                         ::testing::Values("lost-reply", "lost-line", "garbage", "stall"));

class GrblKinds : public ::testing::TestWithParam<GrblHabits> {};

TEST_P(GrblKinds, StandWhereTheyWereToldToBeforeTheCallReturns) {
  GrblBench bench("", GetParam());
  bench.table->Connect(0, false, "", bench.patience);
  for (int i = 1; i <= 14; ++i) {
    bench.table->TurnTo(30.0 * (i % 12), bench.patience);
    EXPECT_LT(bench.Off(30.0 * i), 0.06) << i;
  }
  EXPECT_NEAR(bench.world.table_deg(), 420, 0.06);
}

INSTANTIATE_TEST_SUITE_P(Habits, GrblKinds,
                         ::testing::Values(GrblHabits{.inches = true},
                                           GrblHabits{.inches = true, .lists_settings = false},
                                           GrblHabits{.early_idle = 3}, GrblHabits{.two_oks = true},
                                           GrblHabits{.lists_settings = false}));

TEST(GrblTurntable, ThatHearsOnlyAResetAfterALimitIsResetAndItsAngleAskedFor) {
  GrblBench bench("", {.limit_at_move = 2});
  bench.table->Connect(0, false, "", bench.patience);
  bench.table->TurnTo(30, bench.patience);
  EXPECT_THROW(bench.table->TurnTo(60, bench.patience), PositionLost);
  bench.world.SetTable(60);  // by hand
  bench.table->Declare(60, bench.patience);
  bench.table->TurnTo(90, bench.patience);
  EXPECT_LT(bench.Off(90), kClose_deg);
}

TEST(GrblTurntable, GoesOnInMidTurnWhenThePulledCableIsBack) {
  GrblBench bench("unplug@1");
  bench.table->Connect(0, false, "", bench.patience);
  EXPECT_THROW(bench.table->TurnTo(120, bench.patience), DeviceFault);
  EXPECT_THROW(bench.table->Connect(0, true, "", bench.patience), DeviceFault);  // not back yet
  bench.patience.Wait(0.5);
  bench.table->Connect(0, true, "", bench.patience);
  bench.table->TurnTo(120, bench.patience);
  EXPECT_LT(bench.Off(120), kClose_deg);
}

TEST(GrblTurntable, SaysThatItsAngleIsUnknownAfterAResetInMidTurn) {
  GrblBench bench("reset@1");
  bench.table->Connect(0, false, "", bench.patience);
  EXPECT_THROW(bench.table->TurnTo(120, bench.patience), PositionLost);
  EXPECT_THROW(bench.table->Connect(0, true, "", bench.patience), PositionLost);
  bench.world.SetTable(120);  // by hand
  bench.table->Declare(120, bench.patience);
  bench.table->TurnTo(135, bench.patience);
  EXPECT_LT(bench.Off(135), kClose_deg);
}

TEST(GrblTurntable, InTheHandsOfANewProgramDoesNotTrustATurnThatWasUnderWay) {
  GrblBench bench;
  EXPECT_THROW(bench.table->Connect(15, true, "", bench.patience), PositionLost);
}

TEST(GrblTurntable, ThatStaysSilentIsAFaultThatNeedsNoHand) {
  GrblBench bench("mute@1");
  bench.table->Connect(0, false, "", bench.patience);
  try {
    bench.table->TurnTo(120, bench.patience);
    FAIL() << "it was not silent";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.code, "table-silent");
    EXPECT_FALSE(fault.needs_hand);
  }
}

}  // namespace keypose::capture::shoot::grbl_firmware_test
