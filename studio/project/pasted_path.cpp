#include "studio/project/pasted_path.h"

#include <cctype>
#include <string_view>

namespace keypose::studio {
namespace {

constexpr std::string_view kSpaces = " \t\r\n";

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(kSpaces);
  if (begin == std::string::npos) return "";
  return text.substr(begin, text.find_last_not_of(kSpaces) + 1 - begin);
}

/// %20 and the like as bytes.
std::string Unescaped(std::string_view text) {
  std::string plain;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto is_digit = [&](std::size_t at) {
      return at < text.size() && std::isxdigit(static_cast<unsigned char>(text[at])) != 0;
    };
    if (text[i] != '%' || !is_digit(i + 1) || !is_digit(i + 2)) {
      plain += text[i];
      continue;
    }
    plain += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
    i += 2;
  }
  return plain;
}

}  // namespace

std::string PastedPath(std::string text) {
  text = Trimmed(text);
  for (const char quote : {'\'', '"'})
    if (text.size() > 1 && text.front() == quote && text.back() == quote)
      text = Trimmed(text.substr(1, text.size() - 2));
  for (const std::string_view scheme : {"file://localhost/", "file:///"})
    if (text.starts_with(scheme))
      return Unescaped(std::string_view(text).substr(scheme.size() - 1));
  return text;
}

}  // namespace keypose::studio
