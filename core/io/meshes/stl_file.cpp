#include "core/io/meshes/stl_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "core/io/meshes/face_colors.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kStlHeader = 80, kStlStart = 84, kTriangleBytes = 50;

template <class T>
T StlNumber(std::string_view bytes, std::size_t at) {
  T value{};
  std::memcpy(&value, bytes.data() + at, sizeof(T));
  return value;
}

std::uint64_t WholeSize(std::string_view bytes) {
  return kStlStart + std::uint64_t{kTriangleBytes} * StlNumber<std::uint32_t>(bytes, kStlHeader);
}

using StlCorner = std::array<double, 3>;

struct StlCornerHash {
  std::size_t operator()(const StlCorner& corner) const {
    std::uint64_t hash = 0;
    for (const double value : corner)
      hash = (hash ^ std::bit_cast<std::uint64_t>(value)) * 0x9E3779B97F4A7C15u ^ hash >> 29;
    return static_cast<std::size_t>(hash ^ hash >> 32);
  }
};

/// Makes one vertex of equal corners.
class Welder {
 public:
  void Add(const std::array<StlCorner, 3>& triangle) {
    std::array<int, 3> face{};
    for (std::size_t k = 0; k < 3; ++k) {
      StlCorner corner = triangle[k];
      for (double& value : corner) value += 0.0;  // -0 is 0
      const auto [entry, is_new] = ids_.emplace(corner, static_cast<int>(points_.size()));
      if (is_new) points_.push_back(corner);
      face[k] = entry->second;
    }
    faces_.push_back(face);
  }

  Mesh Take() const {
    Mesh mesh;
    mesh.points.resize(std::ssize(points_), 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      for (int k = 0; k < 3; ++k)
        mesh.points(static_cast<Eigen::Index>(v), k) = points_[v][static_cast<std::size_t>(k)];
    mesh.faces.resize(std::ssize(faces_), 3);
    for (std::size_t f = 0; f < faces_.size(); ++f)
      for (int k = 0; k < 3; ++k)
        mesh.faces(static_cast<Eigen::Index>(f), k) = faces_[f][static_cast<std::size_t>(k)];
    return mesh;
  }

 private:
  std::unordered_map<StlCorner, int, StlCornerHash> ids_;
  std::vector<StlCorner> points_;
  std::vector<std::array<int, 3>> faces_;
};

[[noreturn]] void FailStl(const fs::path& path, const std::string& why) {
  throw InputError(fmt::format("cannot read STL file {}: {}", path.string(), why));
}

class BinaryStl {
 public:
  BinaryStl(const fs::path& path, std::string_view bytes) : path_(path), bytes_(bytes) {}

  NotedMesh Read() {
    NotedMesh noted;
    const std::uint64_t whole = RequireWhole();
    Welder welder;
    for (std::uint64_t at = kStlStart; at < whole; at += kTriangleBytes) Add(at, &welder);
    noted.mesh = welder.Take();
    if (PutColors(&noted.mesh)) noted.notes.push_back(kColorsBlend);
    if (bytes_.size() > whole)
      noted.notes.push_back(fmt::format("{} bytes behind its {} triangles are left out",
                                        bytes_.size() - whole, attributes_.size()));
    return noted;
  }

 private:
  /// @return the size of header and triangles
  std::uint64_t RequireWhole() const {
    if (bytes_.size() < kStlStart)
      FailStl(path_, "it is malformed or truncated (a binary one has 84 bytes or more)");
    const auto count = StlNumber<std::uint32_t>(bytes_, kStlHeader);
    const std::uint64_t whole = WholeSize(bytes_), held = (bytes_.size() - kStlStart) / 50;
    if (bytes_.size() < whole)
      FailStl(path_,
              fmt::format("it claims {} triangles and holds {}; it is truncated", count, held));
    if (count == 0 && held > 0)
      FailStl(path_, fmt::format("it claims 0 triangles, but has {} bytes behind its header; "
                                 "export it again",
                                 bytes_.size() - kStlStart));
    return whole;
  }

  void Add(std::uint64_t at, Welder* welder) {
    std::array<StlCorner, 3> triangle;
    for (std::size_t k = 0; k < 9; ++k) {
      const auto value = static_cast<double>(StlNumber<float>(bytes_, at + 12 + 4 * k));
      if (!std::isfinite(value))
        FailStl(path_, fmt::format("triangle {} has a corner that is not finite; repair the file "
                                   "and export it again",
                                   attributes_.size()));
      triangle[k / 3][k % 3] = value;
    }
    welder->Add(triangle);
    attributes_.push_back(StlNumber<std::uint16_t>(bytes_, at + 48));
  }

  /// Five bits each, the lowest first.
  static Eigen::RowVector3d Levels(std::uint16_t bits) {
    return Eigen::RowVector3d(bits & 31, bits >> 5 & 31, bits >> 10 & 31) * (255.0 / 31);
  }

  /// The colour of the whole, as Magics writes it.
  std::optional<Eigen::RowVector3d> ColorOfAll() const {
    const std::size_t mark = bytes_.substr(0, kStlHeader).find("COLOR=");
    if (mark == bytes_.npos || mark + 10 > kStlHeader) return {};
    Eigen::RowVector3d color;
    for (int c = 0; c < 3; ++c)
      color[c] = static_cast<unsigned char>(bytes_[mark + 6 + static_cast<std::size_t>(c)]);
    return color;
  }

  /// Whether all faces say that they have no colour of their own, and have some: so MeshLab and
  /// toxiclibs write Magics' colours.
  bool HaveUnsaidColors() const {
    bool some = false;
    for (const std::uint16_t bits : attributes_) {
      if (bits >> 15 == 0) return false;
      const int color = bits & 0x7fff;
      some |= color != 0 && color != 0x7fff;
    }
    return some;
  }

  /// Magics: red is lowest, and the highest bit says that the face has the colour of the whole.
  /// VisCAM, SolidView: blue is lowest, and the highest bit says that there is a colour.
  bool PutColors(Mesh* mesh) const {
    const std::optional<Eigen::RowVector3d> all = ColorOfAll();
    const bool none = std::all_of(attributes_.begin(), attributes_.end(),
                                  [](std::uint16_t bits) { return bits == 0; }),
               unsaid = all && HaveUnsaidColors();
    const auto own = [&](std::uint16_t bits) {
      return unsaid || (!none && (bits >> 15 == 1) != all.has_value());
    };
    const bool grey = !all || ((*all)[0] == (*all)[1] && (*all)[1] == (*all)[2]);
    // Grey is what a mesh without colours is.
    if (grey && std::none_of(attributes_.begin(), attributes_.end(), own)) return false;
    Eigen::MatrixX3d levels(std::ssize(attributes_), 3);
    for (std::size_t f = 0; f < attributes_.size(); ++f) {
      const auto row = static_cast<Eigen::Index>(f);
      const Eigen::RowVector3d color = Levels(attributes_[f]);
      if (own(attributes_[f]))
        levels.row(row) = all ? color : color.reverse();
      else
        levels.row(row) =
            all.value_or(Eigen::RowVector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
    }
    return TakeFaceColors(levels, mesh);
  }

  const fs::path& path_;
  std::string_view bytes_;
  std::vector<std::uint16_t> attributes_;
};

bool IsStlSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

class TextStl {
 public:
  TextStl(const fs::path& path, std::string_view text) : path_(path), text_(text) {
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  }

  NotedMesh Read() {
    Expect("solid");
    SkipName();
    bool open = true, colored = false;
    for (std::string word = Next(); !word.empty(); word = Next()) {
      const bool solid = word == "solid", end = word == "endsolid" || word == "end";
      if (open ? solid : !solid) FailHere(word);
      if (solid || end) {
        open = solid;
        if (word == "end") Expect("solid");
        SkipName();
      } else if (word == "facet") {
        ReadFacet();
      } else if (word == "color") {  // of a whole solid, as Creo writes it
        for (int k = 0; k < 3; ++k) Number();
        colored = true;
      } else {
        FailHere(word);
      }
    }
    if (open) Fail("it ends without 'endsolid'; it is malformed or truncated");
    NotedMesh noted{welder_.Take(), {}};
    if (colored) noted.notes.push_back("colours of its solids (color) are left out");
    return noted;
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    FailStl(path_, fmt::format("line {}: {}", line_, why));
  }
  [[noreturn]] void FailHere(const std::string& word) const {
    Fail(fmt::format("'{}' is malformed or in the wrong place",
                     WithoutOddBytes(word.substr(0, 40))));
  }

  void SkipSpaces() {
    for (; at_ < text_.size() && IsStlSpace(text_[at_]); ++at_) line_ += text_[at_] == '\n';
  }

  /// In small letters; empty: there is none.
  std::string Next() {
    SkipSpaces();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !IsStlSpace(text_[at_])) ++at_;
    return LowerCase(std::string(text_.substr(begin, at_ - begin)));
  }

  void Expect(const char* word) {
    const std::string next = Next();
    if (next.empty()) Fail("it is truncated");
    if (next != word) FailHere(next);
  }

  /// A name goes to the end of its line, or to the first facet in that.
  void SkipName() {
    const std::size_t end = std::min(text_.find_first_of("\r\n", at_), text_.size());
    const std::size_t facet =
        LowerCase(std::string(text_.substr(at_, end - at_))).find("facet normal");
    at_ = facet == text_.npos ? end : at_ + facet;
  }

  double Number() {
    SkipSpaces();
    const std::size_t begin = at_;
    while (at_ < text_.size() && !IsStlSpace(text_[at_])) ++at_;
    std::string_view word = text_.substr(begin, at_ - begin);
    if (word.empty()) Fail("it is truncated");
    const std::string written(word);
    if (word.starts_with('+')) word.remove_prefix(1);
    double value = 0;
    const char* const stop = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), stop, value);
    if (error == std::errc::result_out_of_range) value = std::strtod(written.c_str(), nullptr);
    if (error == std::errc::invalid_argument || end != stop || !std::isfinite(value))
      Fail(fmt::format("'{}' is no finite number", WithoutOddBytes(written.substr(0, 40))));
    return value;
  }

  void ReadFacet() {
    Expect("normal");
    for (int k = 0; k < 3; ++k) Next();  // some programs write nan for faces without area
    Expect("outer");
    Expect("loop");
    std::array<StlCorner, 3> triangle;
    for (StlCorner& corner : triangle) {
      Expect("vertex");
      for (double& value : corner) value = Number();
    }
    const std::string next = Next();
    if (next == "vertex") Fail("a facet has more than three corners; export it as triangles");
    if (next != "endloop") FailHere(next);
    Expect("endfacet");
    welder_.Add(triangle);
  }

  const fs::path& path_;
  std::string_view text_;
  std::size_t at_ = 0, line_ = 1;
  Welder welder_;
};

bool HasText(std::string_view bytes) {
  const std::string_view head = bytes.substr(0, 4096);
  const std::size_t begin = head.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  return begin != head.npos && LowerCase(std::string(head.substr(begin, 5))) == "solid" &&
         head.find('\0') == head.npos;
}

}  // namespace

bool IsWholeBinaryStl(const fs::path& path, std::string_view head) {
  return head.size() >= kStlStart && fs::file_size(path) == WholeSize(head);
}

bool LooksLikeBinaryStl(const fs::path& path, std::string_view head) {
  if (head.size() < kStlStart || head.find('\0') == head.npos) return false;
  if (LowerExtension(path) == ".stl") return true;
  std::size_t at = kStlStart;
  for (; at + kTriangleBytes <= head.size() && at < WholeSize(head); at += kTriangleBytes) {
    double length = 0;
    for (std::size_t k = 0; k < 12; ++k) {
      const auto value = static_cast<double>(StlNumber<float>(head, at + 4 * k));
      if (!std::isfinite(value) || std::abs(value) > 1e9) return false;
      if (k < 3) length += value * value;
    }
    if (std::abs(length - 1) > 0.01) return false;
  }
  return at > kStlStart;
}

NotedMesh ReadStl(const fs::path& path) {
  const std::string bytes = ReadFile(path);
  if (HasText(bytes) && !IsWholeBinaryStl(path, bytes)) return TextStl(path, bytes).Read();
  return BinaryStl(path, bytes).Read();
}

}  // namespace keypose
