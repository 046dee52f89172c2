#include "core/values/left_out.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace keypose {
namespace {

std::string EncodedName(const std::string& name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const auto c = static_cast<unsigned char>(name[i]);
    const bool edge = i == 0 || i + 1 == name.size();
    if (c == '%' || c == ';' || c < 0x20 || c == 0x7f || (edge && c == ' '))
      text += fmt::format("%{:02X}", c);
    else
      text += name[i];
  }
  return text;
}

/// %XX is a character; any other % stays.
std::string DecodedName(std::string_view name) {
  std::string text;
  for (std::size_t i = 0; i < name.size(); ++i) {
    int code = 0;
    const char* const begin = name.data() + i + 1;
    const bool coded = name[i] == '%' && i + 2 < name.size() &&
                       std::from_chars(begin, begin + 2, code, 16).ptr == begin + 2 && code > 0;
    text += coded ? static_cast<char>(code) : name[i];
    if (coded) i += 2;
  }
  return text;
}

std::string_view Trimmed(std::string_view text) {
  constexpr const char* kSpaces = " \t\r\n";
  const std::size_t first = text.find_first_not_of(kSpaces);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kSpaces) - first + 1);
}

}  // namespace

std::vector<std::string> ParseLeftOut(const std::string& text) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at <= text.size();) {
    const std::size_t end = std::min(text.find(';', at), text.size());
    const std::string name = DecodedName(Trimmed(std::string_view(text).substr(at, end - at)));
    if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(name);
    at = end + 1;
  }
  return names;
}

std::string LeftOutText(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : "; ") + EncodedName(name);
  return text;
}

bool MeansPhotograph(const std::string& name, const std::filesystem::path& file,
                     const std::string& written) {
  return name == file.generic_string() || name == file.filename() || name == written;
}

}  // namespace keypose
