#include <gtest/gtest.h>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/steps_turntable.h"
#include "capture/shoot/simulation/turntable_bench.h"

namespace keypose::capture::shoot::steps_firmware_test {

constexpr int kSteps = 3200;
constexpr double kStep_deg = 360.0 / kSteps;

StepsTimes Fast() {
  StepsTimes times;
  times.reply_s = 0.05, times.ask_s = 0.005, times.stall_s = 0.2, times.wake_up_s = 0.5;
  return times;
}

struct Bench : TurntableBench {
  explicit Bench(const std::string& planned = "")
      : TurntableBench(MakeStepsFirmware(kSteps), planned),
        table(MakeStepsTurntable(folder / "port", Fast())) {}
  std::unique_ptr<TurntableDevice> table;
};

TEST(StepsTurntable, StandsWhereItWasToldToAllRoundTheCircle) {
  Bench bench;
  bench.table->Connect(0, false, "", bench.patience);
  for (int i = 0; i <= 24; ++i) {
    bench.table->TurnTo(15.0 * (i % 24), bench.patience);
    EXPECT_LT(bench.Off(15.0 * i), kStep_deg) << i;
  }
  EXPECT_NEAR(bench.world.table_deg(), 360, kStep_deg);  // once round, and not back
}

TEST(StepsTurntable, KeepsTheAngleThatItHadBeforeTheProgramStarted) {
  Bench bench;
  bench.world.SetTable(90);
  bench.table->Connect(90, false, "", bench.patience);
  bench.table->TurnTo(105, bench.patience);
  EXPECT_LT(bench.Off(105), kStep_deg);
}

class StepsFaults : public ::testing::TestWithParam<const char*> {};

TEST_P(StepsFaults, TurnTheTableOnceAndOnlyOnce) {
  Bench bench(std::string(GetParam()) + "@2");
  bench.table->Connect(0, false, "", bench.patience);
  bench.table->TurnTo(30, bench.patience);
  bench.table->TurnTo(60, bench.patience);
  EXPECT_LT(bench.Off(60), kStep_deg);
  bench.table->TurnTo(90, bench.patience);
  EXPECT_LT(bench.Off(90), kStep_deg);
}

INSTANTIATE_TEST_SUITE_P(Protocol, StepsFaults,
                         ::testing::Values("lost-reply", "lost-line", "garbage", "stall"));

TEST(StepsTurntable, GoesOnInMidTurnWhenThePulledCableIsBack) {
  Bench bench("unplug@1");
  bench.table->Connect(0, false, "", bench.patience);
  const std::string memory = bench.table->Memory();
  try {
    bench.table->TurnTo(120, bench.patience);
    FAIL() << "the cable was not pulled";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.code, "table-gone");
    EXPECT_FALSE(fault.needs_hand);
  }
  bench.patience.Wait(0.5);
  bench.table->Connect(0, true, memory, bench.patience);
  bench.table->TurnTo(120, bench.patience);
  EXPECT_LT(bench.Off(120), kStep_deg);
}

TEST(StepsTurntable, SaysThatItsAngleIsUnknownAfterAResetInMidTurn) {
  Bench bench("reset@1");
  bench.table->Connect(0, false, "", bench.patience);
  const std::string memory = bench.table->Memory();
  EXPECT_THROW(bench.table->TurnTo(120, bench.patience), PositionLost);
  EXPECT_THROW(bench.table->Connect(0, true, memory, bench.patience), PositionLost);
  bench.world.SetTable(120);  // by hand
  bench.table->Declare(120, bench.patience);
  bench.table->TurnTo(135, bench.patience);
  EXPECT_LT(bench.Off(135), kStep_deg);
}

TEST(StepsTurntable, ThatStaysSilentIsAFaultThatNeedsNoHand) {
  Bench bench("mute@1");
  bench.table->Connect(0, false, "", bench.patience);
  try {
    bench.table->TurnTo(30, bench.patience);
    FAIL() << "it was not silent";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.code, "table-silent");
    EXPECT_FALSE(fault.needs_hand);
  }
}

}  // namespace keypose::capture::shoot::steps_firmware_test
