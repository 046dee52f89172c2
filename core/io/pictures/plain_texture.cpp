#include "core/io/pictures/plain_texture.h"

#include <functional>
#include <string_view>
#include <utility>

#include "core/io/pictures/image_kind.h"
#include "core/io/pictures/picture_bytes.h"

namespace keypose {
namespace {

using std::string_view_literals::operator""sv;

constexpr std::size_t kPngHead = 33;  ///< bytes of a PNG's signature and first chunk

std::size_t Number(std::string_view bytes, std::size_t at, int count) {
  std::size_t number = 0;
  for (int i = 0; i < count; ++i)
    number = number << 8 | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return number;
}

/// Without those segments of a JPEG; from the picture's data on all stays.
/// @param drop  of a marker's second byte and the segment's data
std::string WithoutSegments(std::string_view jpeg,
                            const std::function<bool(unsigned char, std::string_view)>& drop) {
  constexpr unsigned char kScan = 0xda;
  std::string kept(jpeg.substr(0, 2));
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == '\xff') {
    const auto marker = static_cast<unsigned char>(jpeg[at + 1]);
    const std::size_t length = Number(jpeg, at + 2, 2);
    if (marker == kScan || marker == 0xff || length < 2 || at + 2 + length > jpeg.size()) break;
    if (!drop(marker, jpeg.substr(at + 4, length - 2))) kept += jpeg.substr(at, 2 + length);
    at += 2 + length;
  }
  return kept + std::string(jpeg.substr(at));
}

/// Calls `each` with the type and all bytes of a PNG's chunks.
void ForChunks(std::string_view png,
               const std::function<void(std::string_view, std::string_view)>& each) {
  constexpr std::size_t kSignature = 8, kAround = 12;
  for (std::size_t at = kSignature; at + kAround <= png.size();) {
    const std::size_t size = Number(png, at, 4);
    if (size > png.size() - at - kAround) return;
    each(png.substr(at + 4, 4), png.substr(at, size + kAround));
    at += size + kAround;
  }
}

std::string PlainJpeg(std::string_view jpeg, bool with_profile) {
  constexpr unsigned char kExif = 0xe1, kProfile = 0xe2;
  return WithoutSegments(jpeg, [&](unsigned char marker, std::string_view data) {
    return (marker == kExif && data.starts_with("Exif\0"sv)) ||
           (!with_profile && marker == kProfile && data.starts_with("ICC_PROFILE\0"sv));
  });
}

std::string PlainPng(std::string_view png, const std::string& name, bool with_profile) {
  constexpr int kGrey = 0, kGreyWithAlpha = 4, kColorWithAlpha = 6;
  constexpr std::size_t kColorType = 25;
  std::string kept(png.substr(0, 8)), profile;
  bool alpha = false, srgb = false;
  ForChunks(png, [&](std::string_view type, std::string_view) { srgb |= type == "sRGB"; });
  ForChunks(png, [&](std::string_view type, std::string_view bytes) {
    // Beside the chunk sRGB these say the same again.
    const bool tells_color = type == "iCCP" || (!srgb && (type == "gAMA" || type == "cHRM"));
    if (type == "eXIf" || (tells_color && !with_profile)) return;
    alpha |= type == "tRNS";
    if (type == "iCCP") profile = bytes;
    kept += bytes;
  });
  if (png.size() < kPngHead) return std::string(png);
  const int color_type = png[kColorType];
  if (!alpha && color_type != kGreyWithAlpha && color_type != kColorWithAlpha) return kept;
  if (color_type == kGrey || color_type == kGreyWithAlpha) profile.clear();  // not one of RGB
  return PngBytes(DecodePicture(kept, name)).insert(kPngHead, profile);
}

}  // namespace

std::string PlainTexture(std::string bytes, const std::string& name, bool with_profile) {
  const std::string kind = ImageKindOf(std::string_view(bytes).substr(0, 64));
  if (!IsWholeImage(bytes, kind)) return bytes;  // whoever reads it says so
  if (kind == "jpeg") return PlainJpeg(bytes, with_profile);
  if (kind == "png") return PlainPng(bytes, name, with_profile);
  return bytes;
}

}  // namespace keypose
