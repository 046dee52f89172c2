#pragma once

#include <stdexcept>

namespace keypose::studio {

/// Nothing of that name is there (yet).
struct NotFound : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace keypose::studio
