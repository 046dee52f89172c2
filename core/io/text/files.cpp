#include "core/io/text/files.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <numeric>

#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

/// Number of bytes of the UTF-8 character at the start of `text`; 0 when it is not valid. Source:
/// table 3-7 of the Unicode standard.
std::size_t Utf8Length(std::string_view text) {
  const auto byte = [&](std::size_t k) {
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0u;
  };
  const auto follows = [&](std::size_t k, unsigned low = 0x80, unsigned high = 0xbf) {
    return byte(k) >= low && byte(k) <= high;
  };
  const unsigned lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead >= 0xc2 && lead <= 0xdf) return follows(1) ? 2 : 0;
  if (lead >= 0xe0 && lead <= 0xef)
    return follows(1, lead == 0xe0 ? 0xa0 : 0x80, lead == 0xed ? 0x9f : 0xbf) && follows(2) ? 3 : 0;
  if (lead >= 0xf0 && lead <= 0xf4)
    return follows(1, lead == 0xf0 ? 0x90 : 0x80, lead == 0xf4 ? 0x8f : 0xbf) && follows(2) &&
                   follows(3)
               ? 4
               : 0;
  return 0;
}

/// `text` with each byte that is not valid UTF-8 replaced by `instead`.
template <class Instead>
std::string WithOddBytesAs(std::string_view text, const Instead& instead) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = Utf8Length(text);
    out += length > 0 ? std::string(text.substr(0, length))
                      : instead(static_cast<unsigned char>(text[0]));
    text.remove_prefix(std::max<std::size_t>(1, length));
  }
  return out;
}

}  // namespace

bool IsValidUtf8(std::string_view text) {
  for (std::size_t length = 0; !text.empty(); text.remove_prefix(length)) {
    length = Utf8Length(text);
    if (length == 0) return false;
  }
  return true;
}

std::string WithoutOddBytes(std::string text) {
  if (IsValidUtf8(text)) return text;
  return WithOddBytesAs(text, [](unsigned char) { return std::string("?"); });
}

std::string PrintableName(const fs::path& path) {
  return WithOddBytesAs(path.filename().string(), [](unsigned char byte) {
    constexpr const char* kDigits = "0123456789abcdef";
    return std::string("\\x") + kDigits[byte >> 4] + kDigits[byte & 15];
  });
}

bool IsShallowJson(std::string_view text) {
  constexpr int kMostLevels = 100;
  int level = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted && c == '\\') ++at;  // the next character is escaped
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    level += (c == '[' || c == '{') - (c == ']' || c == '}');
    if (level > kMostLevels) return false;
  }
  return true;
}

void RequireShallowJson(std::string_view text, const std::string& where) {
  if (!IsShallowJson(text))
    throw InputError(
        where + " is nested more than 100 levels deep; it is damaged, or not a file of Keypose");
}

std::string JsonFault(const std::exception& error) {
  const std::string message = error.what();
  const std::size_t end = message.starts_with("[") ? message.find("] ") : std::string::npos;
  return end == std::string::npos ? message : message.substr(end + 2);
}

std::string ReadFile(const fs::path& path) {
  std::error_code missing;
  const fs::file_status status = fs::status(path, missing);
  if (fs::is_directory(status))
    throw DiskError(path.string() + " is a folder, but a file is needed");
  if (fs::exists(status) && !fs::is_regular_file(status))
    throw DiskError(path.string() + " is a pipe or a device, but a file is needed; save it as one");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError("cannot open " + path.string() + ": " + std::strerror(errno));
  // At once: a stream that grows as it is read would copy large files several times over.
  std::error_code unknown;
  const std::uintmax_t size = fs::file_size(path, unknown);
  // One more: then the read that reaches the end has room, and the text need not grow.
  std::string text(unknown ? 1 : size + 1, '\0');
  std::size_t length = 0;
  constexpr std::size_t kMore = 1 << 16;
  while (in) {
    if (length == text.size()) text.resize(length + kMore);  // its length was not known, or it grew
    in.read(text.data() + length, static_cast<std::streamsize>(text.size() - length));
    length += static_cast<std::size_t>(in.gcount());
  }
  if (in.bad()) throw DiskError("cannot read " + path.string() + ": " + std::strerror(errno));
  text.resize(length);
  return text;
}

void WriteFile(const fs::path& path, std::string_view text) {
  errno = 0;
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!out) throw DiskError("cannot write " + path.string() + ": " + std::strerror(errno));
  out.write(text.data(), static_cast<std::streamsize>(text.size()));
  out.close();
  if (!out) {
    const int reason = errno;
    std::error_code ignored;
    if (fs::is_regular_file(path, ignored)) fs::remove(path, ignored);  // must not remove a device
    throw DiskError("cannot write " + path.string() + ": " +
                    (reason ? std::strerror(reason) : "the disk took only a part") +
                    (reason == ENOSPC ? "; free some space and run again" : ""));
  }
}

void WriteFileAtomically(const fs::path& path, std::string_view text) {
  std::error_code unknown;
  const fs::file_status status = fs::status(path, unknown);
  // /dev/stdout or a FIFO: renaming over it would remove the device itself.
  if (fs::exists(status) && !fs::is_regular_file(status) && !fs::is_directory(status))
    return WriteFile(path, text);
  const fs::path temporary = path.string() + ".tmp" + std::to_string(::getpid());
  WriteFile(temporary, text);
  std::error_code error;
  fs::rename(temporary, path, error);
  if (error) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw DiskError("cannot replace " + path.string() + ": " + error.message());
  }
}

std::string NearestWord(const std::string& word, const std::vector<std::string>& words) {
  std::string best;
  std::size_t best_distance = std::string::npos;
  for (const std::string& candidate : words) {
    std::vector<std::size_t> row(candidate.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < word.size(); ++i) {
      std::size_t diagonal = row[0];
      row[0] = i + 1;
      for (std::size_t j = 0; j < candidate.size(); ++j) {
        const std::size_t substituted = diagonal + (word[i] != candidate[j]);
        diagonal = row[j + 1];
        row[j + 1] = std::min({row[j + 1] + 1, row[j] + 1, substituted});
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

}  // namespace keypose
