#include "capture/shoot/devices/line_port.h"

#include <gtest/gtest.h>

#include "capture/shoot/devices/device_fault.h"
#include "capture/shoot/devices/steps_turntable.h"

namespace keypose::capture::shoot::line_port_test {

TEST(SerialPort, ThatIsNotThereIsNamedWithWhatToDo) {
  const auto table = MakeStepsTurntable("/dev/keypose_no_such_port");
  PlainPatience patience;
  try {
    table->Connect(0, false, "", patience);
    FAIL() << "it was opened";
  } catch (const DeviceFault& fault) {
    EXPECT_EQ(fault.code, "table-gone");
    EXPECT_NE(std::string(fault.what()).find("keypose_no_such_port"), std::string::npos);
    EXPECT_NE(fault.what_to_do.find("--turntable"), std::string::npos);
  }
}

}  // namespace keypose::capture::shoot::line_port_test
