#include "keypose_box.h"

namespace keypose_box {

namespace {

// A frame: sync sync kind seq length(2) payload crc(2), low bytes first.
const uint16_t kHead = 6, kTail = 2;

}  // namespace

uint16_t NextCrc(uint16_t crc, uint8_t byte) {
  crc = static_cast<uint16_t>(crc ^ (static_cast<uint16_t>(byte) << 8));
  for (uint8_t bit = 0; bit < 8; ++bit)
    crc = static_cast<uint16_t>((crc & 0x8000) ? (crc << 1) ^ 0x1021 : crc << 1);
  return crc;
}

Box::Box(Sensors& sensors, Line& line, const Card* cards, uint8_t card_count, uint16_t boot)
    : sensors_(sensors), line_(line), cards_(cards), card_count_(card_count), boot_(boot) {
  for (uint8_t c = 0; c < card_count; ++c) count_ = static_cast<uint16_t>(count_ + cards[c].inputs);
  if (count_ > KEYPOSE_BOX_SENSORS) count_ = KEYPOSE_BOX_SENSORS;
  for (uint16_t s = 0; s < count_; ++s) {
    value_[s] = 0;
    changed_[s] = 0;
  }
}

uint16_t Box::Payload16(uint16_t at) const {
  const uint8_t* p = request_ + kHead + at;
  return static_cast<uint16_t>(p[0] | (p[1] << 8));
}

int32_t Box::Payload24(uint16_t at) const {
  const uint8_t* p = request_ + kHead + at;
  return static_cast<int32_t>(p[0]) | (static_cast<int32_t>(p[1]) << 8) |
         (static_cast<int32_t>(p[2]) << 16);
}

uint16_t Box::PayloadLength() const {
  return static_cast<uint16_t>(request_[4] | (request_[5] << 8));
}

void Box::Take(uint8_t byte) {
  if (received_ == 0 && byte != kSync1) return;
  if (received_ == 1 && byte != kSync2) {
    received_ = byte == kSync1 ? 1 : 0;
    return;
  }
  request_[received_++] = byte;
  if (received_ < kHead) return;
  const uint16_t length = PayloadLength();
  if (length > kMostRequest - kHead - kTail) {
    received_ = 0;
    return;
  }
  const uint16_t whole = static_cast<uint16_t>(kHead + length + kTail);
  if (received_ < whole) return;
  received_ = 0;
  uint16_t crc = 0xFFFF;
  for (uint16_t i = 2; i < whole - kTail; ++i) crc = NextCrc(crc, request_[i]);
  if (crc == Payload16(length)) Answer();
}

void Box::Answer() {
  const uint16_t length = PayloadLength();
  switch (request_[2]) {
    case kHello:
      return length == 0 ? SayHello() : SayError(kWrongLength);
    case kRead:
      return length == 0 ? SayAll() : SayError(kWrongLength);
    case kChanges:
      return length == 4 ? SayChanges(Payload16(0), Payload16(2)) : SayError(kWrongLength);
    case kReset:
      return length == 2 ? Reset(Payload16(0)) : SayError(kWrongLength);
    case kPreload:
      return Preload();
    case kFlags:
      return length == 0 ? SayFlags() : SayError(kWrongLength);
    default:
      return SayError(kUnknownKind);
  }
}

void Box::Put8(uint8_t value) {
  crc_ = NextCrc(crc_, value);
  line_.Put(value);
}

void Box::Put16(uint16_t value) {
  Put8(static_cast<uint8_t>(value & 0xFF));
  Put8(static_cast<uint8_t>(value >> 8));
}

void Box::Put24(int32_t value) {
  Put16(static_cast<uint16_t>(value & 0xFFFF));
  Put8(static_cast<uint8_t>((value >> 16) & 0xFF));
}

void Box::Begin(uint8_t kind, uint16_t length) {
  line_.Put(kSync1);
  line_.Put(kSync2);
  crc_ = 0xFFFF;
  Put8(kind);
  Put8(request_[3]);
  Put16(length);
}

void Box::End() {
  const uint16_t crc = crc_;
  line_.Put(static_cast<uint8_t>(crc & 0xFF));
  line_.Put(static_cast<uint8_t>(crc >> 8));
}

void Box::SayError(uint8_t code) {
  Begin(kError, 1);
  Put8(code);
  End();
}

void Box::SayHello() {
  done_kind_ = 0;  // a new host: its first request repeats nothing
  Begin(kHello | kReply, static_cast<uint16_t>(6 + 2 * card_count_));
  Put8(kVersion);
  Put16(boot_);
  Put16(count_);
  Put8(card_count_);
  for (uint8_t c = 0; c < card_count_; ++c) {
    Put8(cards_[c].kind);
    Put8(cards_[c].inputs);
  }
  End();
}

void Box::Sample() {
  ++mark_;
  sensors_.Latch();
  for (uint16_t s = 0; s < count_; ++s) {
    const int32_t now = sensors_.Count(s) & 0xFFFFFF;
    if (now == value_[s]) continue;
    value_[s] = now;
    changed_[s] = mark_;
  }
}

uint8_t Box::AnyFlag() {
  for (uint16_t s = 0; s < count_; ++s)
    if (sensors_.Flags(s)) return 1;
  return 0;
}

void Box::SayAll() {
  Sample();
  PutAll();
}

void Box::PutAll() {
  Begin(kRead | kReply, static_cast<uint16_t>(7 + 3 * count_));
  Put16(boot_);
  Put16(mark_);
  Put8(AnyFlag());
  Put16(count_);
  for (uint16_t s = 0; s < count_; ++s) Put24(value_[s]);
  End();
}

// Marks wrap. One that is more than half a round old looks new, and its sensor is told again, which
// does no harm; one that is new always looks new.
bool Box::IsNew(uint16_t sensor, uint16_t since) const {
  return static_cast<int16_t>(changed_[sensor] - since) > 0;
}

void Box::SayChanges(uint16_t boot, uint16_t since) {
  const int16_t age = static_cast<int16_t>(mark_ - since);
  if (boot != boot_ || age < 0) return SayAll();
  Sample();
  uint16_t changed = 0;
  for (uint16_t s = 0; s < count_; ++s) changed = static_cast<uint16_t>(changed + IsNew(s, since));
  if (5UL * changed > 3UL * count_) return PutAll();  // it is shorter
  Begin(kChanges | kReply, static_cast<uint16_t>(7 + 5 * changed));
  Put16(boot_);
  Put16(mark_);
  Put8(AnyFlag());
  Put16(changed);
  for (uint16_t s = 0; s < count_; ++s) {
    if (!IsNew(s, since)) continue;
    Put16(s);
    Put24(value_[s]);
  }
  End();
}

void Box::SayFlags() {
  Begin(kFlags | kReply, static_cast<uint16_t>(4 + count_));
  Put16(boot_);
  Put16(count_);
  for (uint16_t s = 0; s < count_; ++s) Put8(sensors_.Flags(s));
  End();
}

bool Box::IsRepeated() {
  const uint16_t crc = Payload16(PayloadLength());
  const bool repeated = done_kind_ == request_[2] && done_seq_ == request_[3] && done_crc_ == crc;
  done_kind_ = request_[2];
  done_seq_ = request_[3];
  done_crc_ = crc;
  return repeated;
}

void Box::SayDone() {
  Begin(request_[2] | kReply, 2);
  Put16(boot_);
  End();
}

void Box::Reset(uint16_t sensor) {
  if (sensor != kAllSensors && sensor >= count_) return SayError(kNoSuchSensor);
  if (!IsRepeated())
    for (uint16_t s = 0; s < count_; ++s)
      if (sensor == kAllSensors || sensor == s) sensors_.SetCount(s, 0);
  SayDone();
}

void Box::Preload() {
  const uint16_t length = PayloadLength();
  const uint16_t wanted = length >= 2 ? Payload16(0) : 0;
  if (length < 2 || wanted > kMostPreloads || length != 2 + 5 * wanted)
    return SayError(kWrongLength);
  for (uint16_t i = 0; i < wanted; ++i)
    if (Payload16(static_cast<uint16_t>(2 + 5 * i)) >= count_) return SayError(kNoSuchSensor);
  if (!IsRepeated())
    for (uint16_t i = 0; i < wanted; ++i)
      sensors_.SetCount(Payload16(static_cast<uint16_t>(2 + 5 * i)),
                        Payload24(static_cast<uint16_t>(4 + 5 * i)));
  SayDone();
}

}  // namespace keypose_box
