// The message of an InputError.
#pragma once

#include <string>

#include "core/values/errors.h"

namespace keypose::capture {

template <class Call>
std::string MessageOf(const Call& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was thrown";
}

}  // namespace keypose::capture
