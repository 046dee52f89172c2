// A controller box from an Arduino Mega 2560 and counter cards: firmware for `keypose armature`.
//
// A card has sixteen LS7366R counters on the SPI bus, which count all edges of their encoders in 24
// bits by themselves, and a 74HC154 that selects one of them. Analogue inputs (strain gauges with
// amplifiers, potentiometers) go to A0 to A15. The wiring is in docs/armature-protocol.md.
//
// Not tried on a board yet: armature/firmware_sketch_test.cpp runs it on the host, with fake chips.
#include <EEPROM.h>
#include <SPI.h>

#include "keypose_box.h"

using namespace keypose_box;

// What is plugged in. Sensors are numbered through in this order.
const Card kCards[] = {
    {kEncoders, 16}, {kEncoders, 16}, {kEncoders, 16}, {kEncoders, 16}, {kEncoders, 10},
};
const uint8_t kCardCount = sizeof(kCards) / sizeof(kCards[0]);
const uint32_t kBaud = 1000000;

// The enable line of each encoder card's 74HC154 (active low), and the four address lines that all
// of them share.
const uint8_t kCardPins[] = {22, 23, 24, 25, 26, 27, 28, 29};
const uint8_t kAddressPins[] = {30, 31, 32, 33};

// LS7366R: two bits of operation, three of register.
const uint8_t kWriteMode0 = 0x88, kWriteMode1 = 0x90, kWriteData = 0x98, kClearStatus = 0x30,
              kLoadCounter = 0xE0, kLatchCounter = 0xE8, kReadLatch = 0x68, kReadStatus = 0x70;
const uint8_t kAllEdges = 0x03, kThreeBytes = 0x01, kPowerLost = 0x04;

class Bench final : public Sensors {
 public:
  void Begin() {
    for (uint8_t pin : kAddressPins) pinMode(pin, OUTPUT);
    for (uint8_t pin : kCardPins) {
      digitalWrite(pin, HIGH);
      pinMode(pin, OUTPUT);
    }
    SPI.begin();
    SPI.beginTransaction(SPISettings(4000000, MSBFIRST, SPI_MODE0));
    for (uint16_t s = 0; Find(s); ++s)
      if (kCards[card_].kind == kEncoders) SetModes();
  }

  // Whether some counter has lost its power since it was last set.
  bool LostPower() {
    for (uint16_t s = 0; Find(s); ++s)
      if (Flags(s) & kLostCount) return true;
    return false;
  }

  void SetAllToZero() {
    for (uint16_t s = 0; Find(s); ++s) SetCount(s, 0);
  }

  // Commands of one byte, a few microseconds each: 74 counters are latched within half a
  // millisecond.
  void Latch() override {
    for (uint16_t s = 0; Find(s); ++s)
      if (kCards[card_].kind == kEncoders) Command(kLatchCounter);
  }

  int32_t Count(uint16_t sensor) override {
    if (!Find(sensor)) return 0;
    if (kCards[card_].kind == kAnalogue)
      return static_cast<int32_t>(analogRead(A0 + analogue_)) << 6;
    Select();
    SPI.transfer(kReadLatch);
    int32_t count = 0;
    for (uint8_t byte = 0; byte < 3; ++byte) count = (count << 8) | SPI.transfer(0);
    Release();
    return count;
  }

  void SetCount(uint16_t sensor, int32_t count) override {
    if (!Find(sensor) || kCards[card_].kind == kAnalogue) return;
    SetModes();  // a chip that was without power has lost them
    Select();
    SPI.transfer(kWriteData);
    for (int8_t shift = 16; shift >= 0; shift -= 8) SPI.transfer((count >> shift) & 0xFF);
    Release();
    Command(kLoadCounter);
    Command(kClearStatus);
  }

  uint8_t Flags(uint16_t sensor) override {
    if (!Find(sensor)) return 0;
    if (kCards[card_].kind == kAnalogue) {
      const int reading = analogRead(A0 + analogue_);
      return reading < 4 || reading > 1019 ? kNoSignal : 0;
    }
    Select();
    SPI.transfer(kReadStatus);
    const uint8_t status = SPI.transfer(0);
    Release();
    return status & kPowerLost ? kLostCount : 0;
  }

 private:
  // Which card and input a sensor is.
  bool Find(uint16_t sensor) {
    encoder_card_ = analogue_ = 0;
    for (card_ = 0; card_ < kCardCount; ++card_) {
      const bool encoders = kCards[card_].kind == kEncoders;
      if (sensor < kCards[card_].inputs) {
        input_ = sensor;
        analogue_ += encoders ? 0 : sensor;
        return true;
      }
      sensor -= kCards[card_].inputs;
      encoder_card_ += encoders;
      analogue_ += encoders ? 0 : kCards[card_].inputs;
    }
    return false;
  }
  void Select() {
    for (uint8_t bit = 0; bit < 4; ++bit) digitalWrite(kAddressPins[bit], (input_ >> bit) & 1);
    digitalWrite(kCardPins[encoder_card_], LOW);
  }
  void Release() { digitalWrite(kCardPins[encoder_card_], HIGH); }
  void Command(uint8_t command) {
    Select();
    SPI.transfer(command);
    Release();
  }
  void Command(uint8_t command, uint8_t data) {
    Select();
    SPI.transfer(command);
    SPI.transfer(data);
    Release();
  }
  void SetModes() {
    Command(kWriteMode0, kAllEdges);
    Command(kWriteMode1, kThreeBytes);
  }

  uint8_t card_ = 0, encoder_card_ = 0, input_ = 0, analogue_ = 0;
};

class SerialLine final : public Line {
 public:
  void Put(uint8_t byte) override { Serial.write(byte); }
};

Bench bench;
SerialLine serial_line;
Box* box = nullptr;
unsigned long last_byte_ms = 0;

// In the first two bytes of the EEPROM: one more whenever counters have lost their power; all of
// them then begin at 0, as a host expects of a new number. When only this board began again, as it
// does when a program opens its port, the counters have run on, and the number stays.
uint16_t BootNumber() {
  const uint16_t last = EEPROM.read(0) | (EEPROM.read(1) << 8);
  if (!bench.LostPower()) return last;
  const uint16_t boot = last + 1;
  EEPROM.update(0, boot & 0xFF);
  EEPROM.update(1, boot >> 8);
  bench.SetAllToZero();
  return boot;
}

void setup() {
  Serial.begin(kBaud);
  bench.Begin();
  static Box the_box(bench, serial_line, kCards, kCardCount, BootNumber());
  box = &the_box;
}

void loop() {
  if (Serial.available()) {
    last_byte_ms = millis();
    box->Take(Serial.read());
  } else if (millis() - last_byte_ms > 20) {
    box->LineIsQuiet();
  }
}
