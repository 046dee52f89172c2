// The controller box's side of the serial protocol (docs/armature-protocol.md).
//
// It is compiled twice: for the microcontroller, where firmware.ino gives it bytes and
// encoders, and on the host, where the simulated controller and the tests do. So it needs C++11 and
// no library, no heap, and at most 2.5 KB of RAM with sixteen cards.
#ifndef KEYPOSE_BOX_H
#define KEYPOSE_BOX_H

#include <stdint.h>

namespace keypose_box {

/// Sixteen cards of sixteen. A board with little RAM may be built with fewer.
#ifndef KEYPOSE_BOX_SENSORS
#define KEYPOSE_BOX_SENSORS 256
#endif

const uint8_t kSync1 = 0xA5, kSync2 = 0x5A;
const uint8_t kVersion = 1;
const uint16_t kAllSensors = 0xFFFF;
const uint16_t kMostPreloads = 64;  ///< sensors in one request

enum Kind : uint8_t {
  kHello = 0x01,
  kRead = 0x02,
  kChanges = 0x03,
  kReset = 0x04,
  kPreload = 0x05,
  kFlags = 0x06,
  kReply = 0x80,  ///< added to the request's kind
  kError = 0xFF
};

enum ErrorCode : uint8_t { kUnknownKind = 1, kWrongLength = 2, kNoSuchSensor = 3 };

enum CardKind : uint8_t {
  kEncoders = 1,  ///< 24-bit counters that wrap
  kAnalogue = 2   ///< readings from 0 to 65535 that do not
};

/// What may be wrong with a sensor.
enum Flag : uint8_t {
  kLostCount = 1,  ///< its counter lost power since it was last reset or preloaded
  kNoSignal = 2    ///< its line is dead, or its reading is at an end of the range
};

struct Card {
  uint8_t kind;
  uint8_t inputs;
};

/// The sensors of a board. They are numbered through, card after card.
class Sensors {
 public:
  /// Takes a snapshot of all counters, as nearly at one moment as the board can.
  virtual void Latch() = 0;
  /// A counter as it was latched: its low 24 bits; or an analogue reading.
  virtual int32_t Count(uint16_t sensor) = 0;
  /// Sets a counter. Analogue inputs ignore it.
  virtual void SetCount(uint16_t sensor, int32_t count) = 0;
  virtual uint8_t Flags(uint16_t sensor) = 0;

 protected:
  ~Sensors() {}
};

/// Where replies go.
class Line {
 public:
  virtual void Put(uint8_t byte) = 0;

 protected:
  ~Line() {}
};

/// CRC-16 with polynomial 0x1021, from 0xFFFF, high bit first; "123456789" gives 0x29B1.
uint16_t NextCrc(uint16_t crc, uint8_t byte);

class Box {
 public:
  /// @param cards  in the order of their sensors; all must outlive this
  /// @param boot   another number after each power-up
  Box(Sensors& sensors, Line& line, const Card* cards, uint8_t card_count, uint16_t boot);

  /// A byte from the host. A reply goes out when it completes a request.
  void Take(uint8_t byte);
  /// To be called when 20 ms went by without a byte: what was begun is dropped, so that a byte that
  /// was lost does not swallow the next request.
  void LineIsQuiet() { received_ = 0; }

 private:
  void Answer();
  void Begin(uint8_t kind, uint16_t length);
  void Put8(uint8_t value);
  void Put16(uint16_t value);
  void Put24(int32_t value);
  void End();
  void SayError(uint8_t code);
  void SayHello();
  void SayAll();
  void PutAll();
  void SayChanges(uint16_t boot, uint16_t since);
  void SayFlags();
  void Reset(uint16_t sensor);
  void Preload();
  void SayDone();
  void Sample();
  bool IsRepeated();
  uint8_t AnyFlag();
  bool IsNew(uint16_t sensor, uint16_t since) const;
  uint16_t Payload16(uint16_t at) const;
  int32_t Payload24(uint16_t at) const;
  uint16_t PayloadLength() const;

  Sensors& sensors_;
  Line& line_;
  const Card* cards_;
  uint8_t card_count_;
  uint16_t boot_, count_ = 0;

  static const uint16_t kMostRequest = 8 + 2 + 5 * kMostPreloads;
  uint8_t request_[kMostRequest];
  uint16_t received_ = 0;
  uint16_t crc_ = 0;  ///< of the reply that is going out
  /// The last request that changed a counter: it is not carried out twice.
  uint8_t done_kind_ = 0, done_seq_ = 0;
  uint16_t done_crc_ = 0;

  /// One more with each sample; each sensor keeps the mark of the sample in which it changed last.
  uint16_t mark_ = 0;
  int32_t value_[KEYPOSE_BOX_SENSORS];
  uint16_t changed_[KEYPOSE_BOX_SENSORS];
};

}  // namespace keypose_box

#endif
