#include "pipeline/text/text.h"

#include <fmt/format.h>
#include <utf8proc.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <sstream>

namespace keypose::pipeline {
namespace {

struct Letter {
  std::size_t begin = 0, size = 0;  ///< bytes
  utf8proc_int32_t code = 0xfffd;   ///< the replacement character if the bytes are not UTF-8
  bool valid = false;
  std::size_t width = 1;  ///< columns
};

std::vector<Letter> LettersOf(const std::string& text) {
  std::vector<Letter> letters;
  for (std::size_t at = 0; at < text.size();) {
    Letter letter;
    letter.begin = at;
    const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(text.data()) + at;
    const auto used =
        utf8proc_iterate(bytes, static_cast<utf8proc_ssize_t>(text.size() - at), &letter.code);
    letter.valid = used > 0;
    letter.size = letter.valid ? static_cast<std::size_t>(used) : 1;
    if (letter.valid)
      letter.width = static_cast<std::size_t>(std::max(0, utf8proc_charwidth(letter.code)));
    letters.push_back(letter);
    at += letter.size;
  }
  return letters;
}

bool IsLetterOrDigit(utf8proc_int32_t code) {
  switch (utf8proc_category(code)) {
    case UTF8PROC_CATEGORY_LU:
    case UTF8PROC_CATEGORY_LL:
    case UTF8PROC_CATEGORY_LT:
    case UTF8PROC_CATEGORY_LM:
    case UTF8PROC_CATEGORY_LO:
    case UTF8PROC_CATEGORY_MN:
    case UTF8PROC_CATEGORY_MC:
    case UTF8PROC_CATEGORY_ND:
    case UTF8PROC_CATEGORY_NL:
    case UTF8PROC_CATEGORY_NO:
      return true;
    default:
      return false;
  }
}

}  // namespace

bool IsUtf8(const std::string& text) {
  const auto letters = LettersOf(text);
  return std::all_of(letters.begin(), letters.end(),
                     [](const Letter& letter) { return letter.valid; });
}

std::string Composed(const std::string& text) {
  utf8proc_uint8_t* composed = nullptr;
  const auto options = static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE);
  const auto size = utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                                 static_cast<utf8proc_ssize_t>(text.size()), &composed, options);
  if (size < 0) return text;
  std::string result(reinterpret_cast<const char*>(composed), static_cast<std::size_t>(size));
  std::free(composed);
  return result;
}

bool IsName(const std::string& text) {
  const auto letters = LettersOf(text);
  const auto fine = [](const Letter& letter) {
    return letter.valid &&
           (IsLetterOrDigit(letter.code) || letter.code == '-' || letter.code == '_');
  };
  return !text.empty() && text[0] != '-' && std::all_of(letters.begin(), letters.end(), fine);
}

std::size_t WidthOf(const std::string& text) {
  std::size_t width = 0;
  for (const Letter& letter : LettersOf(text)) width += letter.width;
  return width;
}

std::string CutTo(const std::string& text, std::size_t columns) {
  std::size_t width = 0;
  for (const Letter& letter : LettersOf(text)) {
    width += letter.width;
    if (width > columns) return text.substr(0, letter.begin);
  }
  return text;
}

std::vector<std::string> Wrapped(const std::string& text, std::size_t columns) {
  std::vector<std::string> lines(1);
  std::size_t width = 0;
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    const std::size_t more = WidthOf(word);
    if (columns > 0 && width > 0 && width + 1 + more > columns) {
      lines.emplace_back();
      width = 0;
    }
    lines.back() += (width > 0 ? " " : "") + word;
    width += more + (width > 0);
  }
  return lines;
}

std::string ShellWord(const std::string& text) {
  const auto plain = [](unsigned char c) {
    return std::isalnum(c) || c >= 0x80 ||
           std::string("/._-+=:@%,").find(static_cast<char>(c)) != std::string::npos;
  };
  if (!text.empty() && std::all_of(text.begin(), text.end(), plain)) return text;
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::string SizeText(std::uint64_t bytes) {
  if (bytes >= 1000000000) return fmt::format("{:.1f} GB", static_cast<double>(bytes) / 1e9);
  if (bytes >= 1000000) return fmt::format("{:.1f} MB", static_cast<double>(bytes) / 1e6);
  return fmt::format("{} kB", (bytes + 999) / 1000);
}

}  // namespace keypose::pipeline
