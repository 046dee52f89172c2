// What firmware.ino uses of the Arduino's library, for a bench of fake chips on the host.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

inline constexpr int OUTPUT = 1, LOW = 0, HIGH = 1, MSBFIRST = 1, SPI_MODE0 = 0, A0 = 54;

/// The board's pins, clock and lines.
struct FakeBoard {
  std::array<int, 100> pins = {};
  std::array<int, 16> analogue = {};
  std::function<void(int pin, int level)> on_pin;
  std::function<std::uint8_t(std::uint8_t)> on_spi;
  std::array<std::uint8_t, 16> eeprom = {};
  std::deque<std::uint8_t> from_host;
  std::string to_host;
  unsigned long now_ms = 0;
};
inline FakeBoard board;

inline void pinMode(int, int) {}
inline void digitalWrite(int pin, int level) {
  board.pins[static_cast<std::size_t>(pin)] = level;
  if (board.on_pin) board.on_pin(pin, level);
}
inline int analogRead(int pin) { return board.analogue[static_cast<std::size_t>(pin - A0)]; }
inline unsigned long millis() { return board.now_ms; }

struct FakeSerial {
  void begin(long) {}
  int available() { return static_cast<int>(board.from_host.size()); }
  int read() {
    const int byte = board.from_host.front();
    board.from_host.pop_front();
    return byte;
  }
  void write(std::uint8_t byte) { board.to_host.push_back(static_cast<char>(byte)); }
};
inline FakeSerial Serial;
