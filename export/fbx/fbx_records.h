// The layout of binary FBX files: named records, each with values and inner records.
//
// Source: A. Barton, "FBX binary file format specification", Blender developers' blog, 2013, and
// files written by Autodesk's library.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace keypose::exporting {

constexpr std::int32_t kFbxVersion = 7400;
/// Version 7.4 counts its bytes with 32 bits.
constexpr std::size_t kLargestFbx = 0xFFFFFFFF;
/// The time for which the codes at the start and the end of each file are valid. Autodesk's readers
/// compare them, and all files are written with this time, so that they do not depend on the clock.
constexpr const char* kFbxCreationTime = "1970-01-01 10:00:00:000";

/// One value of a record, in the bytes of the file. Arrays are compressed where that is shorter.
class FbxValue {
 public:
  // Implicit, so that a record's values can be listed.
  FbxValue(bool value);
  FbxValue(std::int32_t value);
  FbxValue(std::int64_t value);
  FbxValue(double value);
  FbxValue(const char* text);
  FbxValue(std::string_view text);
  FbxValue(const std::string& text);
  FbxValue(const std::vector<std::int32_t>& items);
  FbxValue(const std::vector<std::int64_t>& items);
  FbxValue(const std::vector<float>& items);
  FbxValue(const std::vector<double>& items);
  /// Bytes that are not text, such as an image.
  static FbxValue Binary(std::string_view bytes);
  /// @param bytes  type letter and content, as in a file
  static FbxValue Stored(std::string bytes);

  /// A letter: C bool, I and L integers, D double, S text, R bytes; i, l, f, d arrays.
  char type() const { return stored_[0]; }
  const std::string& stored() const { return stored_; }

  /// @throws InputError  a value of another type, or a damaged array
  std::int64_t AsInteger() const;
  std::string AsText() const;  ///< also of bytes
  std::vector<std::int32_t> AsIntegers() const;
  std::vector<std::int64_t> AsTimes() const;
  std::vector<float> AsFloats() const;
  std::vector<double> AsDoubles() const;

 private:
  FbxValue() = default;
  std::string stored_;
};

struct FbxRecord {
  std::string name;  ///< at most 255 bytes
  std::vector<FbxValue> values = {};
  std::vector<FbxRecord> records = {};

  /// The first inner record of this name.
  /// @throws InputError  there is none
  const FbxRecord& Inner(std::string_view inner_name) const;
};

/// A name as objects have it: "clay" of class "Material".
std::string FbxName(const std::string& name, const std::string& class_name);

/// The bytes of a file with header and footer.
/// @param largest_bytes  for tests
/// @throws InputError  more bytes than the format can count
std::string WriteFbx(const std::vector<FbxRecord>& records,
                     std::size_t largest_bytes = kLargestFbx);

/// The records of a file of version 7.4 or older.
/// @throws InputError  not binary FBX, another version, cut off or damaged
std::vector<FbxRecord> ReadFbx(std::string_view bytes);

}  // namespace keypose::exporting
