#include "export/fbx/fbx_records.h"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <utility>

#include "core/values/errors.h"

namespace keypose::exporting {
namespace {

using namespace std::string_view_literals;

static_assert(std::endian::native == std::endian::little, "FBX stores the lowest byte first");

constexpr std::string_view kMagic = "Kaydara FBX Binary  \0\x1a\0"sv;
constexpr std::string_view kFooterEnd =
    "\xf8\x5a\x8c\x6a\xde\xf5\xd9\x7e\xec\xe9\x0c\xe3\x75\x8f\x29\x0b"sv;
// Belongs to kFbxCreationTime, as does the FileId of fbx_document.cpp.
constexpr std::string_view kFooterCode =
    "\xfa\xbc\xab\x09\xd0\xc8\xd4\x66\xb1\x76\xfb\x83\x1c\xf7\x26\x7e"sv;
constexpr std::size_t kNullRecordBytes = 13;
constexpr std::size_t kFooterZeros = 120;
// Of 9; 6 takes three times as long for files that are 2 % smaller.
constexpr int kCompressionLevel = 3;
constexpr std::size_t kMostCompression = 1032;  // plain bytes per byte, of zlib

template <class T>
void Append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class T>
std::string Scalar(char type, T value) {
  std::string out(1, type);
  Append(out, value);
  return out;
}

std::string Text(char type, std::string_view text) {
  std::string out(1, type);
  Append(out, static_cast<std::uint32_t>(text.size()));
  out += text;
  return out;
}

std::string Compressed(std::string_view plain) {
  uLongf size = compressBound(plain.size());
  std::string out(size, '\0');
  const int status =
      compress2(reinterpret_cast<Bytef*>(out.data()), &size,
                reinterpret_cast<const Bytef*>(plain.data()), plain.size(), kCompressionLevel);
  if (status != Z_OK) throw SolverError("export: zlib could not compress an array of the FBX file");
  out.resize(size);
  return out;
}

template <class T>
std::string Array(char type, const std::vector<T>& items) {
  const std::string_view plain(reinterpret_cast<const char*>(items.data()),
                               sizeof(T) * items.size());
  const std::string packed = Compressed(plain);
  const bool shorter = packed.size() < plain.size();
  std::string out(1, type);
  Append(out, static_cast<std::uint32_t>(items.size()));
  Append(out, static_cast<std::uint32_t>(shorter));
  Append(out, static_cast<std::uint32_t>(shorter ? packed.size() : plain.size()));
  out += shorter ? std::string_view(packed) : plain;
  return out;
}

[[noreturn]] void Damaged(const std::string& what) {
  throw InputError("export: the FBX file is damaged: " + what + "; export it again");
}

/// Takes numbers and pieces from bytes, in order.
class Cursor {
 public:
  explicit Cursor(std::string_view bytes, std::size_t at = 0) : bytes_(bytes), at_(at) {}
  std::size_t at() const { return at_; }

  std::string_view Take(std::size_t count) {
    if (count > bytes_.size() - at_) Damaged("it ends at byte " + std::to_string(bytes_.size()));
    at_ += count;
    return bytes_.substr(at_ - count, count);
  }
  template <class T>
  T Number() {
    T value;
    std::memcpy(&value, Take(sizeof(T)).data(), sizeof(T));
    return value;
  }

 private:
  std::string_view bytes_;
  std::size_t at_;
};

template <class T>
std::vector<T> Unpacked(const FbxValue& value, char type) {
  if (value.type() != type) Damaged(std::string("a value is no array of type ") + type);
  Cursor cursor(value.stored(), 1);
  const auto count = cursor.Number<std::uint32_t>(), compressed = cursor.Number<std::uint32_t>();
  const std::string_view content = cursor.Take(cursor.Number<std::uint32_t>());
  if (count / kMostCompression > content.size()) Damaged("an array is longer than its content");
  std::vector<T> items(count);
  uLongf size = sizeof(T) * items.size();
  auto* const out = reinterpret_cast<Bytef*>(items.data());
  if (compressed) {
    const uLongf expected = size;
    const int status =
        uncompress(out, &size, reinterpret_cast<const Bytef*>(content.data()), content.size());
    if (status != Z_OK || size != expected) Damaged("an array cannot be uncompressed");
  } else {
    if (content.size() != size) Damaged("an array has another length than it says");
    std::copy(content.begin(), content.end(), reinterpret_cast<char*>(items.data()));
  }
  return items;
}

// Autodesk's library also closes records that have neither values nor inner records with a null
// record, and those of animation stacks and layers.
bool EndsInNull(const FbxRecord& record) {
  return !record.records.empty() || record.values.empty() || record.name == "AnimationStack" ||
         record.name == "AnimationLayer";
}

std::size_t ValueBytes(const FbxRecord& record) {
  std::size_t bytes = 0;
  for (const FbxValue& value : record.values) bytes += value.stored().size();
  return bytes;
}

std::size_t RecordBytes(const FbxRecord& record) {
  std::size_t bytes = kNullRecordBytes + record.name.size() + ValueBytes(record);
  for (const FbxRecord& inner : record.records) bytes += RecordBytes(inner);
  return bytes + (EndsInNull(record) ? kNullRecordBytes : 0);
}

void AppendRecord(std::string& out, const FbxRecord& record) {
  Append(out, static_cast<std::uint32_t>(out.size() + RecordBytes(record)));
  Append(out, static_cast<std::uint32_t>(record.values.size()));
  Append(out, static_cast<std::uint32_t>(ValueBytes(record)));
  Append(out, static_cast<std::uint8_t>(record.name.size()));
  out += record.name;
  for (const FbxValue& value : record.values) out += value.stored();
  for (const FbxRecord& inner : record.records) AppendRecord(out, inner);
  if (EndsInNull(record)) out.append(kNullRecordBytes, '\0');
}

// The version comes four bytes after a multiple of 16, with 5 to 20 zeros before it.
void AppendFooter(std::string& out) {
  out += kFooterCode;
  out.append(16 - out.size() % 16, '\0');
  Append(out, std::int32_t{0});
  Append(out, kFbxVersion);
  out.append(kFooterZeros, '\0');
  out += kFooterEnd;
}

FbxValue ReadValue(Cursor& cursor) {
  const char type = cursor.Take(1)[0];
  std::string stored(1, type);
  const auto take = [&](std::size_t count) { stored += cursor.Take(count); };
  const auto number_at = [&](std::size_t at) {
    std::uint32_t number;
    std::memcpy(&number, stored.data() + at, sizeof(number));
    return number;
  };
  switch (type) {
    case 'C':
      take(1);
      break;
    case 'I':
      take(4);
      break;
    case 'L':
    case 'D':
      take(8);
      break;
    case 'S':
    case 'R':
      take(4);
      take(number_at(1));
      break;
    case 'i':
    case 'l':
    case 'f':
    case 'd':
      take(12);
      take(number_at(9));
      break;
    default:
      Damaged(std::string("a value has the unknown type ") + type);
  }
  return FbxValue::Stored(std::move(stored));
}

/// @return false for the null record that ends a list
bool ReadRecord(Cursor& cursor, FbxRecord& record) {
  const auto end = cursor.Number<std::uint32_t>(), count = cursor.Number<std::uint32_t>();
  cursor.Number<std::uint32_t>();  // bytes of the values, which the values themselves tell
  record.name = cursor.Take(cursor.Number<std::uint8_t>());
  if (end == 0) return false;
  for (std::uint32_t i = 0; i < count; ++i) record.values.push_back(ReadValue(cursor));
  while (cursor.at() < end) {
    FbxRecord inner;
    if (!ReadRecord(cursor, inner)) break;
    record.records.push_back(std::move(inner));
  }
  if (cursor.at() != end) Damaged("record " + record.name + " has another length than it says");
  return true;
}

}  // namespace

FbxValue::FbxValue(bool value) : stored_(Scalar('C', value)) {}
FbxValue::FbxValue(std::int32_t value) : stored_(Scalar('I', value)) {}
FbxValue::FbxValue(std::int64_t value) : stored_(Scalar('L', value)) {}
FbxValue::FbxValue(double value) : stored_(Scalar('D', value)) {}
FbxValue::FbxValue(const char* text) : stored_(Text('S', text)) {}
FbxValue::FbxValue(std::string_view text) : stored_(Text('S', text)) {}
FbxValue::FbxValue(const std::string& text) : stored_(Text('S', text)) {}
FbxValue::FbxValue(const std::vector<std::int32_t>& items) : stored_(Array('i', items)) {}
FbxValue::FbxValue(const std::vector<std::int64_t>& items) : stored_(Array('l', items)) {}
FbxValue::FbxValue(const std::vector<float>& items) : stored_(Array('f', items)) {}
FbxValue::FbxValue(const std::vector<double>& items) : stored_(Array('d', items)) {}

FbxValue FbxValue::Binary(std::string_view bytes) { return Stored(Text('R', bytes)); }

FbxValue FbxValue::Stored(std::string bytes) {
  FbxValue value;
  value.stored_ = std::move(bytes);
  return value;
}

std::int64_t FbxValue::AsInteger() const {
  Cursor cursor(stored_, 1);
  if (type() == 'I') return cursor.Number<std::int32_t>();
  if (type() != 'L') Damaged("a value is no integer");
  return cursor.Number<std::int64_t>();
}

std::string FbxValue::AsText() const {
  if (type() != 'S' && type() != 'R') Damaged("a value is no text");
  return stored_.substr(5);
}

std::vector<std::int32_t> FbxValue::AsIntegers() const {
  return Unpacked<std::int32_t>(*this, 'i');
}
std::vector<std::int64_t> FbxValue::AsTimes() const { return Unpacked<std::int64_t>(*this, 'l'); }
std::vector<float> FbxValue::AsFloats() const { return Unpacked<float>(*this, 'f'); }
std::vector<double> FbxValue::AsDoubles() const { return Unpacked<double>(*this, 'd'); }

const FbxRecord& FbxRecord::Inner(std::string_view inner_name) const {
  for (const FbxRecord& inner : records)
    if (inner.name == inner_name) return inner;
  Damaged("record " + name + " has no " + std::string(inner_name));
}

std::string FbxName(const std::string& name, const std::string& class_name) {
  return name + std::string("\0\1", 2) + class_name;
}

std::string WriteFbx(const std::vector<FbxRecord>& records, std::size_t largest_bytes) {
  std::size_t bytes = kMagic.size() + 2 * kNullRecordBytes + kFooterZeros + 64;  // or a little less
  for (const FbxRecord& record : records) bytes += RecordBytes(record);
  if (bytes > largest_bytes) {
    throw InputError("export: the FBX file would have " + std::to_string(bytes >> 20) +
                     " MiB, more than the 4 GiB that FBX 7.4 can hold; use fewer in-betweens, or "
                     "a format with a file per frame");
  }
  std::string out;
  out.reserve(bytes);
  out += kMagic;
  Append(out, kFbxVersion);
  for (const FbxRecord& record : records) AppendRecord(out, record);
  out.append(kNullRecordBytes, '\0');
  AppendFooter(out);
  return out;
}

std::vector<FbxRecord> ReadFbx(std::string_view bytes) {
  if (!bytes.starts_with(kMagic)) throw InputError("export: this is no binary FBX file");
  Cursor cursor(bytes, kMagic.size());
  const auto version = cursor.Number<std::int32_t>();
  if (version > kFbxVersion)
    throw InputError("export: FBX version " + std::to_string(version) + " cannot be read");
  std::vector<FbxRecord> records;
  for (FbxRecord record; ReadRecord(cursor, record); record = {})
    records.push_back(std::move(record));
  return records;
}

}  // namespace keypose::exporting
