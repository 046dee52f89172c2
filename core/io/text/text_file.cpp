#include "core/io/text/text_file.h"

#include <cstdint>
#include <utility>

#include "core/io/text/files.h"

namespace keypose {
namespace {

using std::string_view_literals::operator""sv;

void Append(std::uint32_t letter, std::string* text) {
  const auto put = [&](std::uint32_t byte) { text->push_back(static_cast<char>(byte)); };
  if (letter < 0x80) return put(letter);
  if (letter < 0x800) {
    put(0xc0 | letter >> 6);
  } else {
    if (letter < 0x10000) {
      put(0xe0 | letter >> 12);
    } else {
      put(0xf0 | letter >> 18);
      put(0x80 | (letter >> 12 & 0x3f));
    }
    put(0x80 | (letter >> 6 & 0x3f));
  }
  put(0x80 | (letter & 0x3f));
}

}  // namespace

std::string FromUtf16(std::string_view bytes) {
  if (bytes.size() < 2) return "";
  const bool marked = bytes.starts_with("\xff\xfe"sv) || bytes.starts_with("\xfe\xff"sv);
  if (!marked && (bytes[0] == 0) == (bytes[1] == 0)) return "";
  const std::size_t high = bytes.starts_with("\xfe\xff"sv) || bytes[0] == 0 ? 0 : 1;
  const auto unit = [&](std::size_t at) {
    return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + high]) << 8 |
                                      static_cast<unsigned char>(bytes[at + 1 - high]));
  };
  std::string text;
  for (std::size_t at = marked ? 2 : 0; at + 1 < bytes.size(); at += 2) {
    std::uint32_t letter = unit(at);
    const bool pair = letter >= 0xd800 && letter < 0xdc00 && at + 3 < bytes.size() &&
                      (unit(at + 2) & 0xfc00) == 0xdc00;
    if (pair) {
      at += 2;
      letter = 0x10000 + ((letter & 0x3ff) << 10 | (unit(at) & 0x3ff));
    }
    Append(letter, &text);
  }
  return text;
}

std::string PlainText(std::string bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF")) return bytes.substr(3);
  std::string decoded = FromUtf16(bytes);
  return decoded.empty() ? std::move(bytes) : decoded;
}

std::string ReadTextFile(const std::filesystem::path& path) { return PlainText(ReadFile(path)); }

}  // namespace keypose
