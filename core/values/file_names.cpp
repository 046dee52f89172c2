#include "core/values/file_names.h"

#include <algorithm>

namespace keypose {

bool IsOneName(std::string_view name) {
  return !name.empty() && name != "." && name != ".." && name.find('/') == std::string_view::npos &&
         name.find('\0') == std::string_view::npos;
}

bool StaysBelow(std::string_view path) {
  for (;;) {
    const std::size_t slash = path.find('/');
    if (!IsOneName(path.substr(0, slash))) return false;
    if (slash == std::string_view::npos) return true;
    path.remove_prefix(slash + 1);
  }
}

bool IsWithin(const std::filesystem::path& inner, const std::filesystem::path& outer) {
  return std::mismatch(outer.begin(), outer.end(), inner.begin(), inner.end()).first == outer.end();
}

std::string LowerCase(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

std::string LowerExtension(const std::filesystem::path& file) {
  return LowerCase(file.extension().string());
}

}  // namespace keypose
