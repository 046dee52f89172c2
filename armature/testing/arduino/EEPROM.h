#pragma once

#include "armature/testing/arduino/Arduino.h"

struct FakeEeprom {
  std::uint8_t read(int at) { return board.eeprom[static_cast<std::size_t>(at)]; }
  void update(int at, int value) {
    board.eeprom[static_cast<std::size_t>(at)] = static_cast<std::uint8_t>(value);
  }
};
inline FakeEeprom EEPROM;
