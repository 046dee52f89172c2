// The wire format of protocol buffers: reading and writing of fields, as far as ONNX files need it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace keypose::capture {

/// One field of a message.
struct WireField {
  std::uint32_t number = 0;     ///< of the message's definition
  std::uint32_t kind = 0;       ///< 0: `value`; 1, 2 and 5: `bytes`
  std::uint64_t value = 0;      ///< of an integer
  std::string_view bytes = {};  ///< of a text, of packed numbers or of a message inside
};

/// The fields of a message, in the file's order. They point into `message`.
/// @throws InputError  not such a message: it ends within a field, or has an unknown kind
std::vector<WireField> WireFields(std::string_view message);

/// Appends the field of an integer.
void PutInteger(std::string& message, std::uint32_t number, std::uint64_t value);
/// Appends the field of a text or of a message inside.
void PutBytes(std::string& message, std::uint32_t number, std::string_view bytes);
/// Appends a field as it was read.
void PutField(std::string& message, const WireField& field);

}  // namespace keypose::capture
