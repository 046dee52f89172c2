// Frames of the controller's protocol, as the host writes and reads them
// (docs/armature-protocol.md). Written apart from the firmware's own, which tests it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace keypose::armature {

/// What follows a frame's sync bytes, without its CRC.
struct WireFrame {
  std::uint8_t kind = 0, seq = 0;
  std::string payload;
};

/// CRC-16 with polynomial 0x1021, from 0xFFFF, high bit first.
std::uint16_t WireCrc(std::string_view bytes);

/// The bytes of a frame. @pre frame.payload.size() < 65536
std::string EncodeFrame(const WireFrame& frame);

/// Finds frames in bytes that may be damaged or begin anywhere.
class WireFrameReader {
 public:
  void Push(std::string_view bytes) { bytes_ += bytes; }
  /// The next whole frame; nothing until more bytes have come. Bytes of no frame are passed over.
  std::optional<WireFrame> Next();
  /// Frames whose CRC was wrong, so far.
  int damaged() const { return damaged_; }
  void Clear() { bytes_.clear(); }

 private:
  std::string bytes_;
  int damaged_ = 0;
};

/// Numbers in a payload, low bytes first.
void PutU16(std::string* payload, unsigned value);
/// The low 24 bits.
void PutI24(std::string* payload, std::int32_t value);

/// Reads a payload; `fine` becomes false when it is too short.
class PayloadReader {
 public:
  explicit PayloadReader(std::string_view payload) : payload_(payload) {}
  unsigned U8() { return Take(1); }
  unsigned U16() { return Take(2); }
  std::int32_t U24() { return static_cast<std::int32_t>(Take(3)); }
  bool fine() const { return fine_; }
  bool at_end() const { return at_ == payload_.size(); }

 private:
  unsigned Take(std::size_t bytes);
  std::string_view payload_;
  std::size_t at_ = 0;
  bool fine_ = true;
};

}  // namespace keypose::armature
