#include "capture/shoot/devices/steps_lines.h"

#include <charconv>
#include <cstdio>
#include <sstream>

namespace keypose::capture::shoot {
namespace {

/// The whole text as a number.
template <class T>
std::optional<T> NumberOf(std::string_view text, int base = 10) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::uint8_t Crc8(std::string_view bytes) {
  unsigned crc = 0;
  for (const char byte : bytes) {
    crc ^= static_cast<unsigned char>(byte);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 0x80 ? (crc << 1) ^ 0x07 : crc << 1) & 0xff;
  }
  return static_cast<std::uint8_t>(crc);
}

std::string FormatStepsLine(char mark, const StepsLine& line) {
  const std::string body = std::to_string(line.sequence) + " " + line.text;
  char sum[4];
  std::snprintf(sum, sizeof sum, "*%02X", Crc8(body));
  return mark + body + sum;
}

std::optional<StepsLine> ParseStepsLine(char mark, std::string_view line) {
  const std::size_t begin = line.rfind(mark), star = line.rfind('*');
  if (begin == std::string_view::npos || star == std::string_view::npos || star < begin)
    return std::nullopt;
  const std::string_view body = line.substr(begin + 1, star - begin - 1);
  const std::string_view sum = line.substr(star + 1);
  const auto given = NumberOf<unsigned>(sum, 16);
  const std::size_t space = body.find(' ');
  if (sum.size() != 2 || !given || *given != Crc8(body) || space == std::string_view::npos)
    return std::nullopt;
  const auto sequence = NumberOf<int>(body.substr(0, space));
  if (!sequence || *sequence < 0 || *sequence > 255) return std::nullopt;
  return StepsLine{*sequence, std::string(body.substr(space + 1))};
}

std::map<std::string, std::int64_t> StepsValues(std::string_view reply) {
  std::map<std::string, std::int64_t> values;
  std::istringstream words{std::string(reply)};
  for (std::string word; words >> word;) {
    const std::size_t sign = word.find('=');
    if (sign == std::string::npos) continue;
    if (const auto value = NumberOf<std::int64_t>(std::string_view(word).substr(sign + 1)))
      values[word.substr(0, sign)] = *value;
  }
  return values;
}

}  // namespace keypose::capture::shoot
