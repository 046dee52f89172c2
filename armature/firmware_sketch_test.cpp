// The sketch for the Arduino, with fake counter chips behind its pins, read by the host's link.
#include "armature/firmware/firmware.ino"

#include <gtest/gtest.h>

#include <map>

#include "armature/controller/box_link.h"

namespace keypose::armature::firmware_sketch_test {

/// An LS7366R as its data sheet has it: what the sketch uses of it.
struct FakeCounter {
  std::int32_t counter = 0, data = 0, latch = 0;
  std::uint8_t mode0 = 0, mode1 = 0, status = 0x04;  // power was lost

  std::uint8_t Transfer(std::uint8_t byte) {
    if (at_ == 0) {
      command_ = byte;
      if (byte == 0x30) status = 0;
      if (byte == 0xE0) counter = data;
      if (byte == 0xE8) latch = counter;
      if (byte == 0x98) data = 0;
    }
    return at_++ == 0 ? 0 : Byte(byte);
  }
  void Deselect() { at_ = 0; }

 private:
  std::uint8_t Byte(std::uint8_t byte) {
    if (command_ == 0x88) mode0 = byte;
    if (command_ == 0x90) mode1 = byte;
    if (command_ == 0x98) data = data << 8 | byte;
    if (command_ == 0x70) return status;
    return command_ == 0x68 ? static_cast<std::uint8_t>(latch >> (8 * (4 - at_))) : 0;
  }
  std::uint8_t command_ = 0;
  int at_ = 0;
};

/// Five cards of sixteen on the bus, of which the pins select one chip.
class Chips {
 public:
  Chips() {
    board.on_pin = [this](int pin, int level) {
      if (pin < 22 || pin > 29) return;
      if (level == HIGH && selected_) selected_->Deselect();
      selected_ = level == LOW ? &At(pin - 22, Address()) : nullptr;
    };
    board.on_spi = [this](std::uint8_t byte) {
      return selected_ ? selected_->Transfer(byte) : std::uint8_t{0xFF};
    };
  }
  FakeCounter& At(int card, int input) { return chips_[{card, input}]; }
  FakeCounter& Sensor(int sensor) { return At(sensor / 16, sensor % 16); }

 private:
  static int Address() {
    int address = 0;
    for (int bit = 0; bit < 4; ++bit)
      address |= board.pins[static_cast<std::size_t>(30 + bit)] << bit;
    return address;
  }
  std::map<std::pair<int, int>, FakeCounter> chips_;
  FakeCounter* selected_ = nullptr;
};

class SketchLine final : public ByteLine {
 public:
  void Write(std::string_view bytes) override {
    for (const char byte : bytes) board.from_host.push_back(static_cast<std::uint8_t>(byte));
    while (!board.from_host.empty()) loop();
  }
  std::string Read(double) override { return std::exchange(board.to_host, {}); }
};

TEST(FirmwareSketch, CountsResetsAndTellsOfLostPower) {
  Chips chips;
  setup();
  SketchLine line;
  BoxLink link(line);
  EXPECT_EQ(link.Greet().boot, 1);
  EXPECT_EQ(link.info().sensors, 74);
  for (int s = 0; s < 74; ++s) {
    EXPECT_EQ(chips.Sensor(s).mode0, 0x03) << s;  // all edges
    EXPECT_EQ(chips.Sensor(s).mode1, 0x01) << s;  // three bytes
    chips.Sensor(s).counter = 1000 * s - 20000;
  }
  ASSERT_TRUE(link.Update());
  for (int s = 0; s < 74; ++s) EXPECT_EQ(link.counts()[s], (1000 * s - 20000) & 0xFFFFFF);
  EXPECT_FALSE(link.alarm());
  chips.Sensor(73) = FakeCounter();  // its card lost power
  ASSERT_TRUE(link.Update());
  EXPECT_TRUE(link.alarm());
  EXPECT_EQ(link.ReadFlags()[73], kFlagLostCount);
  link.Reset(-1);
  EXPECT_EQ(chips.Sensor(40).counter, 0);
  link.Preload({{17, -5}});
  EXPECT_EQ(chips.Sensor(17).counter & 0xFFFFFF, 0xFFFFFB);
  ASSERT_TRUE(link.Update());
  EXPECT_EQ(link.counts()[17], 0xFFFFFB);
  EXPECT_FALSE(link.alarm());
  EXPECT_EQ(chips.Sensor(73).mode0, 0x03);  // it counts all edges again
}

TEST(FirmwareSketch, HasANewNumberOnlyWhenCountersLostTheirPower) {
  Chips chips;
  bench.Begin();
  const int boot = BootNumber();
  chips.Sensor(5).counter = 2133;
  bench.Begin();  // a program opened the port, and the board began again
  EXPECT_EQ(BootNumber(), boot);
  EXPECT_EQ(chips.Sensor(5).counter, 2133);
  chips.Sensor(40) = FakeCounter();
  bench.Begin();
  EXPECT_EQ(BootNumber(), boot + 1);
  for (int s = 0; s < 74; ++s) EXPECT_EQ(chips.Sensor(s).counter, 0) << s;
  EXPECT_EQ(BootNumber(), boot + 1);
}

TEST(FirmwareSketch, DropsAHalfRequestWhenTheLineIsQuiet) {
  board.from_host = {0xA5, 0x5A, 0x02, 0x01, 0x40};
  while (!board.from_host.empty()) loop();
  board.now_ms += 30;
  loop();
  SketchLine line;
  BoxLink link(line, {0.01, 1});
  EXPECT_EQ(link.Greet().sensors, 74);
}

}  // namespace keypose::armature::firmware_sketch_test
