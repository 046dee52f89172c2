#include "core/io/meshes/ply_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr int kMostHeaderLines = 100000;

enum class PlyFormat { kAscii, kLittle, kBig };

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  std::optional<PlyType> length;  ///< of a list
  std::vector<double>* column = nullptr;
  PlyList* list = nullptr;
};

struct PlyRows {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

constexpr std::array<std::pair<const char*, PlyType>, 16> kPlyTypes = {
    {{"char", PlyType::kInt8},
     {"int8", PlyType::kInt8},
     {"uchar", PlyType::kUint8},
     {"uint8", PlyType::kUint8},
     {"short", PlyType::kInt16},
     {"int16", PlyType::kInt16},
     {"ushort", PlyType::kUint16},
     {"uint16", PlyType::kUint16},
     {"int", PlyType::kInt32},
     {"int32", PlyType::kInt32},
     {"uint", PlyType::kUint32},
     {"uint32", PlyType::kUint32},
     {"float", PlyType::kFloat32},
     {"float32", PlyType::kFloat32},
     {"double", PlyType::kFloat64},
     {"float64", PlyType::kFloat64}}};

std::size_t BytesOf(PlyType type) {
  constexpr std::array<std::size_t, 8> kBytes = {1, 1, 2, 2, 4, 4, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

bool IsReal(PlyType type) { return type == PlyType::kFloat32 || type == PlyType::kFloat64; }

template <class T>
double As(const char* at, bool swapped) {
  std::array<char, sizeof(T)> bytes;
  std::memcpy(bytes.data(), at, sizeof(T));
  if (swapped) std::reverse(bytes.begin(), bytes.end());
  return static_cast<double>(std::bit_cast<T>(bytes));
}

double BinaryNumber(const char* at, PlyType type, bool swapped) {
  switch (type) {
    case PlyType::kInt8:
      return As<std::int8_t>(at, swapped);
    case PlyType::kUint8:
      return As<std::uint8_t>(at, swapped);
    case PlyType::kInt16:
      return As<std::int16_t>(at, swapped);
    case PlyType::kUint16:
      return As<std::uint16_t>(at, swapped);
    case PlyType::kInt32:
      return As<std::int32_t>(at, swapped);
    case PlyType::kUint32:
      return As<std::uint32_t>(at, swapped);
    case PlyType::kFloat32:
      return As<float>(at, swapped);
    case PlyType::kFloat64:
      return As<double>(at, swapped);
  }
  return 0;
}

/// The next line of the header and its number; lines end with \n, \r\n or \r.
bool NextHeaderLine(std::string_view text, std::size_t* at, std::string* line) {
  if (*at >= text.size()) return false;
  const std::size_t end = std::min(text.find_first_of("\r\n", *at), text.size());
  line->assign(text.substr(*at, end - *at));
  *at = end + 1;
  if (end + 1 < text.size() && text[end] == '\r' && text[end + 1] == '\n') ++*at;
  *at = std::min(*at, text.size());
  return true;
}

std::vector<std::string> HeaderWords(const std::string& line) {
  std::istringstream in(LowerCase(line));
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

class PlyReader {
 public:
  explicit PlyReader(const fs::path& path) : path_(path), text_(ReadFile(path)) {}

  PlyTable Read() {
    if (text_.starts_with("\xef\xbb\xbf")) at_ = 3;
    ReadHeader();
    for (PlyRows& element : elements_) Prepare(&element);
    for (PlyRows& element : elements_)
      for (std::size_t row = 0; row < element.count; ++row) ReadRow(&element, row);
    if (format_ == PlyFormat::kAscii) RequireEnd();
    return std::move(table_);
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError(fmt::format("cannot read PLY file {}: {}", path_.string(), why));
  }
  [[noreturn]] void FailAtLine(const std::string& why) const {
    Fail(fmt::format("line {}: {}", line_, why));
  }

  void ReadHeader() {
    std::string line;
    bool has_format = false;
    for (line_ = 1; line_ < kMostHeaderLines && NextHeaderLine(text_, &at_, &line); ++line_) {
      const std::vector<std::string> words = HeaderWords(line);
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") {
        if (!has_format) FailAtLine("the header ends without a line 'format'");
        ++line_;
        return;
      }
      if (words[0] == "format") {
        TakeFormat(words);
        has_format = true;
      } else if (words[0] == "element") {
        TakeElement(words);
      } else if (words[0] == "property") {
        TakeProperty(words);
      } else if (line_ > 1 || words[0] != "ply") {
        FailAtLine(fmt::format("'{}' is no line of a PLY header", line.substr(0, 60)));
      }
    }
    Fail("its header has no end (no line 'end_header')");
  }

  void TakeFormat(const std::vector<std::string>& words) {
    const std::string name = words.size() > 1 ? words[1] : "";
    if (name == "ascii") {
      format_ = PlyFormat::kAscii;
    } else if (name == "binary_little_endian") {
      format_ = PlyFormat::kLittle;
    } else if (name == "binary_big_endian") {
      format_ = PlyFormat::kBig;
    } else {
      FailAtLine(fmt::format("the format '{}' is not known", name));
    }
    if (words.size() > 2 && words[2] != "1.0")
      FailAtLine(fmt::format("the version {} of PLY is not known; 1.0 is read", words[2]));
  }

  /// A row takes at least one byte of the file, if the element has properties.
  void TakeElement(const std::vector<std::string>& words) {
    if (words.size() < 3) FailAtLine("an element has a name and a count");
    const std::string& count = words[2];
    PlyRows element{words[1], 0, {}};
    const auto [end, error] =
        std::from_chars(count.data(), count.data() + count.size(), element.count);
    if (error != std::errc() || end != count.data() + count.size() || element.count > text_.size())
      Fail(
          fmt::format("line {} claims {} of '{}', more than the file's {} bytes can hold; it is "
                      "truncated or damaged",
                      line_, count, element.name, text_.size()));
    for (const PlyRows& other : elements_)
      if (other.name == element.name)
        FailAtLine(fmt::format("there are two elements '{}'", element.name));
    elements_.push_back(element);
  }

  PlyType TypeOf(const std::string& name) const {
    for (const auto& [known, type] : kPlyTypes)
      if (name == known) return type;
    FailAtLine(fmt::format("the type '{}' is not known", name));
  }

  void TakeProperty(const std::vector<std::string>& words) {
    if (elements_.empty()) FailAtLine("a property comes before any element");
    const bool list = words.size() > 1 && words[1] == "list";
    if (words.size() < (list ? 5u : 3u)) FailAtLine("a property has a type and a name");
    PlyProperty property;
    property.name = words[list ? 4 : 2];
    property.type = TypeOf(words[list ? 3 : 1]);
    if (list) property.length = TypeOf(words[2]);
    if (list && IsReal(*property.length))
      FailAtLine(fmt::format("the lengths of the lists '{}' are {}, but must be whole numbers",
                             property.name, words[2]));
    for (const PlyProperty& other : elements_.back().properties)
      if (other.name == property.name)
        FailAtLine(fmt::format("there are two properties '{}'", property.name));
    elements_.back().properties.push_back(property);
  }

  void Prepare(PlyRows* element) {
    PlyElement& table = table_[element->name];
    table.count = element->count;
    for (PlyProperty& property : element->properties) {
      // PCL keeps the bits of a colour in a float, which as a number may be NaN.
      const bool packed = property.name == "rgb" || property.name == "rgba";
      if (packed && property.type == PlyType::kFloat32 && format_ != PlyFormat::kAscii)
        property.type = PlyType::kUint32;
      if (property.length) {
        property.list = &table.lists[property.name];
        property.list->offsets.reserve(element->count + 1);
      } else {
        property.column = &table.scalars[property.name];
        property.column->reserve(element->count);
        table.types[property.name] = property.type;
      }
    }
  }

  void ReadRow(PlyRows* element, std::size_t row) {
    for (PlyProperty& property : element->properties) {
      if (!property.length) {
        property.column->push_back(Number(property.type, *element, row));
        continue;
      }
      const double length = Number(*property.length, *element, row);
      const std::size_t least = format_ == PlyFormat::kAscii ? 1 : BytesOf(property.type);
      if (!(length >= 0) || length != std::floor(length) ||
          length > static_cast<double>((text_.size() - at_) / least + 1))
        Fail(
            fmt::format("the list '{}' of '{}' {} claims {} values, which the file cannot hold; it "
                        "is truncated or damaged",
                        property.name, element->name, row, length));
      for (auto k = static_cast<std::size_t>(length); k > 0; --k)
        property.list->values.push_back(Number(property.type, *element, row));
      property.list->offsets.push_back(property.list->values.size());
    }
  }

  [[noreturn]] void FailTruncated(const PlyRows& element, std::size_t row) const {
    Fail(
        fmt::format("it ends at '{}' {} of {}; it is truncated", element.name, row, element.count));
  }

  double Number(PlyType type, const PlyRows& element, std::size_t row) {
    if (format_ == PlyFormat::kAscii) return AsciiNumber(element, row);
    const std::size_t bytes = BytesOf(type);
    if (bytes > text_.size() - at_) FailTruncated(element, row);
    const bool swapped =
        (format_ == PlyFormat::kBig) == (std::endian::native == std::endian::little);
    const double value = BinaryNumber(text_.data() + at_, type, swapped);
    at_ += bytes;
    return value;
  }

  static bool IsSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

  void SkipSpace() {
    for (; at_ < text_.size() && IsSpace(text_[at_]); ++at_)
      if (text_[at_] == '\n') ++line_;
  }

  double AsciiNumber(const PlyRows& element, std::size_t row) {
    SkipSpace();
    if (at_ >= text_.size()) FailTruncated(element, row);
    const char* const begin = text_.data() + at_;
    const char* const stop = text_.data() + text_.size();
    double value = 0;
    const auto [end, error] = std::from_chars(begin + (*begin == '+' ? 1 : 0), stop, value);
    if (error == std::errc::result_out_of_range) value = OutOfRange(begin, end);
    if (error == std::errc::invalid_argument || (end < stop && !IsSpace(*end)))
      FailAtLine(fmt::format("'{}' of '{}' {} is no number", WordAt(begin), element.name, row));
    at_ = static_cast<std::size_t>(end - text_.data());
    return value;
  }

  /// Zero for numbers that are too small, infinity for those that are too large.
  static double OutOfRange(const char* begin, const char* end) {
    return std::strtod(std::string(begin, end).c_str(), nullptr);
  }

  std::string WordAt(const char* begin) const {
    const char* const stop = text_.data() + text_.size();
    const char* const end = std::find_if(begin, stop, IsSpace);
    return WithoutOddBytes(std::string(begin, std::min(end, begin + 40)));
  }

  /// More values than the header says: rows were joined wrongly.
  void RequireEnd() {
    SkipSpace();
    constexpr std::string_view kEndOfText("\x1a\0", 2);  // DOS, and files of fixed size
    while (at_ < text_.size() && kEndOfText.find(text_[at_]) != kEndOfText.npos) ++at_;
    SkipSpace();
    if (at_ < text_.size())
      FailAtLine(
          fmt::format("'{}' comes after all that the header names; its counts or "
                      "properties are not those of the data",
                      WordAt(text_.data() + at_)));
  }

  const fs::path& path_;
  std::string text_;
  std::size_t at_ = 0, line_ = 1;
  PlyFormat format_ = PlyFormat::kAscii;
  std::vector<PlyRows> elements_;
  PlyTable table_;
};

}  // namespace

PlyTable ReadPly(const fs::path& path) { return PlyReader(path).Read(); }

std::vector<std::string> PlyNotes(const fs::path& path, const std::string& key) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError(fmt::format("{} cannot be opened", PrintableName(path)));
  std::string head(1 << 20, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  std::vector<std::string> notes;
  std::size_t at = 0;
  for (std::string line; NextHeaderLine(head, &at, &line);) {
    const std::vector<std::string> words = HeaderWords(line);
    if (!words.empty() && words[0] == "end_header") break;
    if (words.size() < 3 || (words[0] != "comment" && words[0] != "obj_info") || words[1] != key)
      continue;
    const std::size_t found = LowerCase(line).find(key, words[0].size());
    const std::size_t begin = line.find_first_not_of(" \t", found + key.size());
    notes.push_back(line.substr(begin, line.find_last_not_of(" \t") + 1 - begin));
  }
  return notes;
}

}  // namespace keypose
