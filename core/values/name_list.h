// Lists of names as a person writes them into one option.
#pragma once

#include <sstream>
#include <string>
#include <vector>

namespace keypose {

/// The parts between commas, without the spaces around them; empty parts do not count.
inline std::vector<std::string> NamesIn(const std::string& list) {
  std::vector<std::string> names;
  std::istringstream stream(list);
  for (std::string part; std::getline(stream, part, ',');) {
    const auto begin = part.find_first_not_of(' ');
    if (begin == std::string::npos) continue;
    names.push_back(part.substr(begin, part.find_last_not_of(' ') - begin + 1));
  }
  return names;
}

}  // namespace keypose
