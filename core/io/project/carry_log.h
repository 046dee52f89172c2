// Messages for the user about picks that were read from files.
#pragma once

#include <string>
#include <vector>

namespace keypose {

struct CarryLog {
  /// for information
  std::vector<std::string> notes;
  /// the user should check something before they trust the result
  std::vector<std::string> warnings;
  /// picks were accepted although their file does not say which mesh they belong to
  bool unbound = false;
};

}  // namespace keypose
