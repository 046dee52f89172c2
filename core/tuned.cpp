#include "core/tuned.h"

#ifdef KEYPOSE_SENSITIVITY

#include <cstdio>
#include <cstdlib>
#include <string>

namespace keypose {

double TunedValue(const char* file, const char* name, double value) {
  const char* setting = std::getenv("KEYPOSE_TUNED");
  if (setting == nullptr) return value;
  const std::string text = setting;
  const auto equals = text.find('=');
  const auto colon = text.find(':');
  if (equals == std::string::npos || colon == std::string::npos) return value;
  const bool this_one = std::string(file).ends_with(text.substr(0, colon)) &&
                        text.substr(colon + 1, equals - colon - 1) == name;
  if (!this_one) return value;
  std::fprintf(stderr, "tuned: %s = %s\n", name, text.c_str() + equals + 1);
  return std::strtod(text.c_str() + equals + 1, nullptr);
}

}  // namespace keypose

#endif
