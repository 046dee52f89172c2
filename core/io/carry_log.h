// What a person should be told when picks were read from files.
#pragma once

#include <string>
#include <vector>

namespace keypose {

struct CarryLog {
  std::vector<std::string> notes;     ///< all went well
  std::vector<std::string> warnings;  ///< look at it before trusting the result
  bool unbound = false;  ///< picks were believed that do not say on which mesh they were made
};

}  // namespace keypose
