#include "core/io/text/serial_port.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>

#include "core/testing/folder.h"

namespace keypose::serial_port_test {

class SerialPorts : public ::testing::Test, public TestingFolder {
 protected:
  SerialPorts() {
    device_.Open(folder_ / "port");
    port_.Open(folder_ / "port", 115200);
  }
  PseudoTerminal device_;
  SerialPort port_;
};

TEST_F(SerialPorts, BytesArriveAsTheyWereSentBothWays) {
  const std::string all = {'\0', '\n', '\r', '\x03', '\x11', '\x13', '\x7f', '\xff'};
  port_.Write(all);
  std::string arrived;
  for (int i = 0; i < 100 && arrived.size() < all.size(); ++i) arrived += device_.Read(0.05);
  EXPECT_EQ(arrived, all);
  device_.Write(all);
  arrived.clear();
  for (int i = 0; i < 100 && arrived.size() < all.size(); ++i) arrived += port_.Read(0.05);
  EXPECT_EQ(arrived, all);
  EXPECT_EQ(port_.Read(0.01), "");
}

TEST_F(SerialPorts, ACableThatIsOutIsAFault) {
  device_.Close();
  EXPECT_THROW(for (int i = 0; i < 100; ++i) port_.Read(0.05), PortFault);
}

TEST_F(SerialPorts, OneProgramHasItAlone) {
  SerialPort other;
  try {
    other.Open(folder_ / "port", 115200);
    ADD_FAILURE() << "opened twice";
  } catch (const PortFault& fault) {
    EXPECT_EQ(fault.error, EBUSY);
  }
}

TEST(SerialPort, WhatIsNotThereOrNoSpeedIsAFault) {
  const TestingFolder folder;
  SerialPort port;
  EXPECT_THROW(port.Open(folder.path() / "absent", 115200), PortFault);
  EXPECT_FALSE(port.is_open());
  EXPECT_TRUE(IsBaudRate(115200));
  EXPECT_FALSE(IsBaudRate(115201));
}

}  // namespace keypose::serial_port_test
