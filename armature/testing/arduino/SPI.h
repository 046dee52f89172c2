#pragma once

#include "armature/testing/arduino/Arduino.h"

struct SPISettings {
  SPISettings(long, int, int) {}
};

struct FakeSpi {
  void begin() {}
  void beginTransaction(const SPISettings&) {}
  std::uint8_t transfer(std::uint8_t byte) { return board.on_spi(byte); }
};
inline FakeSpi SPI;
