// The message of an exception of one type.
#pragma once

#include <gtest/gtest.h>

#include <string>

namespace keypose::pipeline {

/// Fails the test if `call` throws nothing of that type.
template <class ErrorType, class Call>
std::string MessageOf(const Call& call) {
  try {
    call();
  } catch (const ErrorType& error) {
    return error.what();
  }
  ADD_FAILURE() << "nothing of the expected type was thrown";
  return "";
}

}  // namespace keypose::pipeline
