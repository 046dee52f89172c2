// Fields of protocol buffers, written.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "capture/salience/protobuf_fields.h"

namespace keypose::capture {

inline std::string Integer(std::uint32_t number, std::uint64_t value) {
  std::string message;
  PutInteger(message, number, value);
  return message;
}

inline std::string Bytes(std::uint32_t number, std::string_view bytes) {
  std::string message;
  PutBytes(message, number, bytes);
  return message;
}

}  // namespace keypose::capture
