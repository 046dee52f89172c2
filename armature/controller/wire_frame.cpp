#include "armature/controller/wire_frame.h"

namespace keypose::armature {
namespace {

constexpr char kSync[] = "\xA5\x5A";
constexpr std::size_t kHead = 6, kTail = 2;
/// More than the reply of sixteen cards; a longer frame is noise.
constexpr std::size_t kMostPayload = 2048;

unsigned ByteAt(std::string_view bytes, std::size_t at) {
  return static_cast<unsigned char>(bytes[at]);
}

unsigned WordAt(std::string_view bytes, std::size_t at) {
  return ByteAt(bytes, at) | ByteAt(bytes, at + 1) << 8;
}

}  // namespace

std::uint16_t WireCrc(std::string_view bytes) {
  unsigned crc = 0xFFFF;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned>(static_cast<unsigned char>(byte)) << 8;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ (crc & 0x8000 ? 0x1021u : 0u);
    crc &= 0xFFFF;
  }
  return static_cast<std::uint16_t>(crc);
}

std::string EncodeFrame(const WireFrame& frame) {
  std::string body;
  body.push_back(static_cast<char>(frame.kind));
  body.push_back(static_cast<char>(frame.seq));
  PutU16(&body, static_cast<unsigned>(frame.payload.size()));
  body += frame.payload;
  const unsigned crc = WireCrc(body);
  PutU16(&body, crc);
  return kSync + body;
}

std::optional<WireFrame> WireFrameReader::Next() {
  while (true) {
    const std::size_t begin = bytes_.find(kSync);
    if (begin == std::string::npos) {
      // The last byte may be the first of a frame.
      const bool half = !bytes_.empty() && bytes_.back() == kSync[0];
      bytes_ = half ? std::string(1, kSync[0]) : "";
      return std::nullopt;
    }
    bytes_.erase(0, begin);
    if (bytes_.size() < kHead) return std::nullopt;
    const std::size_t length = WordAt(bytes_, 4);
    if (length <= kMostPayload) {
      const std::size_t whole = kHead + length + kTail;
      if (bytes_.size() < whole) return std::nullopt;
      const std::string_view body = std::string_view(bytes_).substr(2, kHead - 2 + length);
      if (WireCrc(body) == WordAt(bytes_, kHead + length)) {
        WireFrame frame{static_cast<std::uint8_t>(body[0]), static_cast<std::uint8_t>(body[1]),
                        std::string(body.substr(4))};
        bytes_.erase(0, whole);
        return frame;
      }
    }
    // What looked like a frame was none, or was damaged: the next may begin within it.
    ++damaged_;
    bytes_.erase(0, 1);
  }
}

void PutU16(std::string* payload, unsigned value) {
  payload->push_back(static_cast<char>(value & 0xFF));
  payload->push_back(static_cast<char>(value >> 8 & 0xFF));
}

void PutI24(std::string* payload, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  PutU16(payload, bits & 0xFFFF);
  payload->push_back(static_cast<char>(bits >> 16 & 0xFF));
}

unsigned PayloadReader::Take(std::size_t bytes) {
  fine_ = fine_ && at_ + bytes <= payload_.size();
  if (!fine_) return 0;
  unsigned value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= ByteAt(payload_, at_ + i) << (8 * i);
  at_ += bytes;
  return value;
}

}  // namespace keypose::armature
