#include "core/io/pictures/image_kind.h"

#include <algorithm>
#include <array>
#include <utility>

#include "core/io/pictures/photograph_files.h"

namespace keypose {

namespace {

constexpr auto kNone = std::string_view::npos;

std::uint32_t BigEndian(std::string_view bytes, std::size_t at, std::size_t count) {
  std::uint32_t value = 0;
  for (std::size_t k = 0; k < count; ++k)
    value = (value << 8) | static_cast<unsigned char>(bytes[at + k]);
  return value;
}

/// The brands in the first box: HEVC pictures as phones write them. AVIF, which uses the same
/// container, is not among them.
bool IsHeif(std::string_view head) {
  if (head.size() < 16 || head.substr(4, 4) != "ftyp") return false;
  const std::size_t end = std::min<std::size_t>(head.size(), BigEndian(head, 0, 4));
  bool hevc = false, other = false, container = false;
  for (std::size_t at = 8; at + 4 <= end; at += 4) {
    if (at == 12) continue;  // the version of the major brand
    const std::string_view brand = head.substr(at, 4);
    for (const std::string_view known : {"heic", "heix", "heim", "heis", "hevc", "hevx"})
      hevc |= brand == known;
    for (const std::string_view known : {"mif1", "msf1"}) container |= brand == known;
    for (const std::string_view known : {"avif", "avis", "avci", "jpeg"}) other |= brand == known;
  }
  return hevc || (container && !other);
}

/// The position after a marker's segment; kNone when the file ends within it.
std::size_t BehindSegment(std::string_view bytes, std::size_t at) {
  if (at + 2 > bytes.size()) return kNone;
  const std::size_t length = BigEndian(bytes, at, 2);
  return length < 2 || at + length > bytes.size() ? kNone : at + length;
}

/// Goes from marker to marker. Segments are skipped, such as a thumbnail that has its own end
/// marker.
bool IsWholeJpeg(std::string_view bytes) {
  constexpr unsigned kEnd = 0xd9, kStart = 0xd8, kFirstRestart = 0xd0, kTemporary = 0x01;
  for (std::size_t at = bytes.find('\xff', 2); at != kNone && at + 1 < bytes.size();
       at = bytes.find('\xff', at)) {
    const unsigned marker = static_cast<unsigned char>(bytes[at + 1]);
    if (marker == kEnd) return true;
    if (marker == 0xff) {  // a fill byte
      ++at;
      continue;
    }
    at += 2;
    // A zero is a stuffed byte of the picture data. Restart markers and some others have no
    // segment.
    if (marker == 0 || marker == kTemporary || (marker >= kFirstRestart && marker <= kStart))
      continue;
    at = BehindSegment(bytes, at);
    if (at == kNone) return false;
  }
  return false;
}

bool IsWholePng(std::string_view bytes) {
  constexpr std::size_t kSignature = 8, kAround = 12;  // bytes of a chunk that are not its data
  for (std::size_t at = kSignature; at + kAround <= bytes.size();) {
    const std::size_t length = BigEndian(bytes, at, 4);
    if (length > bytes.size() - at - kAround) return false;
    if (bytes.substr(at + 4, 4) == "IEND") return true;
    at += kAround + length;
  }
  return false;
}

}  // namespace

std::string ImageKindOf(std::string_view head) {
  using std::string_view_literals::operator""sv;
  if (head.starts_with("\xff\xd8\xff"sv)) return "jpeg";
  if (head.starts_with("\x89PNG\r\n\x1a\n"sv)) return "png";
  for (const std::string_view mark : {"II*\0"sv, "MM\0*"sv, "II+\0"sv, "MM\0+"sv})
    if (head.starts_with(mark)) return "tiff";
  return IsHeif(head) ? "heif" : "";
}

std::string OtherKindOf(std::string_view head) {
  using std::string_view_literals::operator""sv;
  constexpr std::array<std::pair<std::string_view, const char*>, 14> kOthers = {
      {{"GIF8"sv, "a GIF picture"},
       {"BM"sv, "a BMP picture"},
       {"8BPS"sv, "a Photoshop document"},
       {"\x76\x2f\x31\x01"sv, "an OpenEXR picture"},
       {"\xff\x0a"sv, "a JPEG XL picture"},
       {"\0\0\0\x0cJXL "sv, "a JPEG XL picture"},
       {"\0\0\0\x0cjP  "sv, "a JPEG 2000 picture"},
       {"#?RADIANCE"sv, "a Radiance picture"},
       {"\xabKTX"sv, "a KTX picture (Basis Universal)"},
       {"DDS "sv, "a DDS picture"},
       {"%PDF"sv, "a PDF document"},
       {"<!DOCTYPE"sv, "a web page"},
       {"<html"sv, "a web page"},
       {"PK\x03\x04"sv, "a ZIP file"}}};
  const bool netpbm = head.size() > 2 && head[0] == 'P' && head[1] >= '1' && head[1] <= '7' &&
                      std::string_view(" \t\r\n").find(head[2]) != kNone;
  if (netpbm) return "a PPM, PGM or PBM picture";
  const std::string_view box = head.size() < 12 ? "" : head.substr(4, 8);
  if (head.starts_with("RIFF") && box.ends_with("WEBP")) return "a WebP picture";
  if (box.starts_with("ftyp"))
    return box.substr(4).starts_with("avi") ? "an AVIF picture" : "a video";
  for (const auto& [start, kind] : kOthers)
    if (head.starts_with(start)) return kind;
  return "";
}

bool IsWholeImage(std::string_view bytes, const std::string& kind) {
  if (kind == "jpeg") return IsWholeJpeg(bytes);
  return kind != "png" || IsWholePng(bytes);
}

std::string PhotographFault(std::string_view bytes) {
  if (bytes.empty()) return "is empty";
  const std::string_view head = bytes.substr(0, 4096);
  const std::string kind = ImageKindOf(head), other = OtherKindOf(head);
  if (kind.empty() && !other.empty())
    return "is " + other + ", whatever its name says; save it as JPEG or PNG";
  if (kind.empty())
    return std::string("is no picture that can be read (") + kReadablePhotographs + ")";
  return IsWholeImage(bytes, kind) ? "" : "is cut off: its end is missing; copy it again";
}

std::int64_t ClaimedHeifPixels(std::string_view bytes) {
  // The size of each picture is in a box 'ispe': type, four bytes of version and flags, width,
  // height. The length before it is always 20, which distinguishes it from equal bytes in picture
  // data. Sides are limited to 2^30, so that their product does not overflow.
  const auto side = [&](std::size_t at) {
    return std::min(std::int64_t{1} << 30, std::int64_t{BigEndian(bytes, at, 4)});
  };
  std::int64_t most = 0;
  for (std::size_t at = bytes.find("ispe"); at != kNone; at = bytes.find("ispe", at + 4)) {
    if (at < 4 || at + 16 > bytes.size() || BigEndian(bytes, at - 4, 4) != 20) continue;
    most = std::max(most, side(at + 8) * side(at + 12));
  }
  return most;
}

}  // namespace keypose
