#include "capture/salience/protobuf_fields.h"

#include "core/values/errors.h"

namespace keypose::capture {
namespace {

constexpr std::uint32_t kInteger = 0, kEightBytes = 1, kBytes = 2, kFourBytes = 5;

[[noreturn]] void Broken(const char* why) {
  throw InputError(std::string("the network's file is damaged: ") + why +
                   "; install it again: ./dev setup");
}

std::uint64_t TakeInteger(std::string_view& rest) {
  std::uint64_t value = 0;
  for (int shift = 0; shift < 64; shift += 7) {
    if (rest.empty()) Broken("it ends within a number");
    const auto byte = static_cast<std::uint8_t>(rest.front());
    rest.remove_prefix(1);
    value |= static_cast<std::uint64_t>(byte & 127) << shift;
    if (byte < 128) return value;
  }
  Broken("a number has more than ten bytes");
}

std::string_view TakeBytes(std::string_view& rest, std::uint64_t count) {
  if (count > rest.size()) Broken("it ends within a field");
  const std::string_view taken = rest.substr(0, count);
  rest.remove_prefix(count);
  return taken;
}

void AppendInteger(std::string& message, std::uint64_t value) {
  for (; value >= 128; value >>= 7) message.push_back(static_cast<char>((value & 127) | 128));
  message.push_back(static_cast<char>(value));
}

}  // namespace

std::vector<WireField> WireFields(std::string_view message) {
  std::vector<WireField> fields;
  while (!message.empty()) {
    const std::uint64_t key = TakeInteger(message);
    WireField field{static_cast<std::uint32_t>(key >> 3), static_cast<std::uint32_t>(key & 7)};
    switch (field.kind) {
      case kInteger:
        field.value = TakeInteger(message);
        break;
      case kEightBytes:
        field.bytes = TakeBytes(message, 8);
        break;
      case kBytes:
        field.bytes = TakeBytes(message, TakeInteger(message));
        break;
      case kFourBytes:
        field.bytes = TakeBytes(message, 4);
        break;
      default:
        Broken("it has a field of an unknown kind");
    }
    fields.push_back(field);
  }
  return fields;
}

void PutInteger(std::string& message, std::uint32_t number, std::uint64_t value) {
  AppendInteger(message, (static_cast<std::uint64_t>(number) << 3) | kInteger);
  AppendInteger(message, value);
}

void PutBytes(std::string& message, std::uint32_t number, std::string_view bytes) {
  AppendInteger(message, (static_cast<std::uint64_t>(number) << 3) | kBytes);
  AppendInteger(message, bytes.size());
  message.append(bytes);
}

void PutField(std::string& message, const WireField& field) {
  if (field.kind == kInteger) return PutInteger(message, field.number, field.value);
  if (field.kind == kBytes) return PutBytes(message, field.number, field.bytes);
  AppendInteger(message, (static_cast<std::uint64_t>(field.number) << 3) | field.kind);
  message.append(field.bytes);
}

}  // namespace keypose::capture
