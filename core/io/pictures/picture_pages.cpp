#include "core/io/pictures/picture_pages.h"

#include <cstdint>

namespace keypose {
namespace {

std::uint32_t BigEndianAt(std::string_view bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i)
    value = value << 8 | static_cast<unsigned char>(bytes[at + i]);
  return value;
}

}  // namespace

bool IsAnimatedWebp(std::string_view bytes) {
  constexpr unsigned kAnimated = 2;  // of the extended header's flags
  return bytes.size() > 20 && bytes.starts_with("RIFF") && bytes.substr(8, 8) == "WEBPVP8X" &&
         (static_cast<unsigned char>(bytes[20]) & kAnimated) != 0;
}

int PngFrames(std::string_view bytes) {
  constexpr std::size_t kSignature = 8, kAround = 12;  // bytes of a chunk that are not its data
  for (std::size_t at = kSignature; at + kAround <= bytes.size();) {
    const std::size_t length = BigEndianAt(bytes, at);
    const std::string_view kind = bytes.substr(at + 4, 4);
    if (kind == "acTL" && at + kAround + 8 <= bytes.size()) {
      const std::uint32_t frames = BigEndianAt(bytes, at + 8);
      return frames > 1 && frames < 1u << 30 ? static_cast<int>(frames) : 1;
    }
    if (kind == "IDAT" || length > bytes.size()) break;
    at += kAround + length;
  }
  return 1;
}

}  // namespace keypose
