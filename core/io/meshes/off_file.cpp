#include "core/io/meshes/off_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/io/meshes/face_colors.h"
#include "core/io/meshes/polygon_cut.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/io/meshes/some_colors.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

constexpr double kMostOffCount = 9e15;  // that a double still counts

bool IsOffSpace(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Where the first word begins, behind a byte order mark, spaces and comments.
std::size_t FirstWord(std::string_view text) {
  std::size_t at = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
  for (;;) {
    while (at < text.size() && IsOffSpace(text[at])) ++at;
    if (at >= text.size() || text[at] != '#') return at;
    at = std::min(text.find_first_of("\r\n", at), text.size());
  }
}

struct OffKind {
  bool texture = false, color = false, normal = false, weight = false, dimension = false;
  std::size_t letters = 0;  ///< of the keyword
};

/// Nothing: the word is no keyword of OFF.
std::optional<OffKind> KindOf(std::string_view word) {
  constexpr std::size_t kMostPrefix = 6;  // STCN4n
  std::string capitals(word.substr(0, kMostPrefix + 3));
  for (char& c : capitals)
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  const std::size_t off = capitals.find("OFF");
  if (off == capitals.npos || off > kMostPrefix) return {};
  OffKind kind;
  kind.letters = off + 3;
  for (const char c : word.substr(kind.letters))
    if (c < '0' || c > '9') return {};
  // Only in capitals `n` is told from `N`.
  const bool exact = word.substr(off, 3) == "OFF";
  for (std::size_t i = 0; i < off; ++i) {
    const char c = exact ? word[i] : capitals[i];
    if (c == 'S' && i + 1 < off && capitals[i + 1] == 'T')
      kind.texture = ++i > 0;
    else if (c == 'C')
      kind.color = true;
    else if (c == 'N')
      kind.normal = true;
    else if (c == '4')
      kind.weight = true;
    else if (c == 'n')
      kind.dimension = true;
    else
      return {};
  }
  return kind;
}

std::string_view WordFrom(std::string_view text, std::size_t at) {
  const auto end = std::find_if(text.begin() + static_cast<std::ptrdiff_t>(at), text.end(),
                                [](char c) { return IsOffSpace(c) || c == '#'; });
  return text.substr(at, static_cast<std::size_t>(end - text.begin()) - at);
}

/// A colour as it is written.
struct OffColor {
  Eigen::Vector3d numbers;
  bool whole = false;  ///< written without a point
};

/// Colours as fractions. Above 1 they are levels of 255, and so are whole numbers where any other
/// is above 1: of the specification 0 0 1 may be either.
std::vector<Eigen::Vector3d> Fractions(const std::vector<OffColor>& colors) {
  const bool levels = std::any_of(colors.begin(), colors.end(), [](const OffColor& color) {
    return color.numbers.maxCoeff() > 1;
  });
  std::vector<Eigen::Vector3d> fractions;
  for (const OffColor& color : colors) {
    const bool level = color.numbers.maxCoeff() > 1 || (levels && color.whole);
    fractions.push_back((color.numbers / (level ? 255 : 1)).cwiseMax(0).cwiseMin(1));
  }
  return fractions;
}

class OffFileReader {
 public:
  explicit OffFileReader(const fs::path& path) : path_(path), text_(ReadFile(path)) {}

  NotedMesh Read() {
    ReadKeyword();
    const std::size_t begin = at_;
    try {
      return ReadAll();
    } catch (const InputError&) {
      if (!kind_.color) throw;
      const std::exception_ptr first = std::current_exception();
      at_ = begin;
      other_way_ = true;
      try {
        return ReadAll();
      } catch (const InputError&) {
        std::rethrow_exception(first);
      }
    }
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError("cannot read OFF file " + path_.string() + ": " + why);
  }

  void ReadKeyword() {
    at_ = FirstWord(text_);
    const auto kind = KindOf(WordFrom(text_, at_));
    if (!kind) Fail("its header is malformed (it does not begin with OFF)");
    kind_ = *kind;
    keyword_ = text_.substr(at_, kind_.letters);
    at_ += kind_.letters;
    std::size_t next = at_;
    while (next < text_.size() && (text_[next] == ' ' || text_[next] == '\t')) ++next;
    if (WordFrom(text_, next) != "BINARY") return;
    binary_ = true;
    at_ = std::min(text_.find('\n', next), text_.size() - 1) + 1;
  }

  NotedMesh ReadAll() {
    ReadParts();
    RequireEnd();
    return Take();
  }

  void ReadParts() {
    colored_.clear();
    vertex_colors_.clear();
    face_colors_.clear();
    corners_.clear();
    sizes_.clear();
    color_of_face_.clear();
    mapped_ = false;
    ReadCounts();
    ReadVertices();
    for (std::size_t f = 0; f < faces_; ++f) ReadFace(f);
  }

  // --- numbers ---

  void SkipToWord() {
    while (at_ < text_.size() && (IsOffSpace(text_[at_]) || text_[at_] == '#'))
      at_ = text_[at_] == '#' ? std::min(text_.find_first_of("\r\n", at_), text_.size()) : at_ + 1;
  }

  /// Nothing: the line has no more. Stops before its end.
  std::optional<std::string_view> NextInLine() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t')) ++at_;
    if (at_ >= text_.size() || IsOffSpace(text_[at_]) || text_[at_] == '#') return {};
    const std::string_view word = WordFrom(text_, at_);
    at_ += word.size();
    return word;
  }

  static bool IsNumberWord(std::string_view word, double* value) {
    if (word.starts_with('+')) word.remove_prefix(1);
    const char* const stop = word.data() + word.size();
    const auto [end, error] = std::from_chars(word.data(), stop, *value);
    if (error == std::errc::result_out_of_range && end == stop) {  // too small, or too large
      *value = std::strtod(std::string(word).c_str(), nullptr);
      return std::isfinite(*value);
    }
    return error == std::errc() && end == stop && std::isfinite(*value);
  }

  /// @param what, index  for messages: "vertex", 7
  double NumberOf(std::string_view word, const char* what, std::size_t index) const {
    double value = 0;
    if (!IsNumberWord(word, &value))
      Fail(fmt::format("{} {} is malformed ('{}' is no number)", what, index,
                       WithoutOddBytes(std::string(word.substr(0, 40)))));
    return value;
  }

  std::uint32_t BinaryWord(const char* what, std::size_t index) {
    if (text_.size() - at_ < 4) FailTruncated(what, index);
    std::uint32_t bits = 0;
    std::memcpy(&bits, text_.data() + at_, 4);
    at_ += 4;
    return little_ == (std::endian::native == std::endian::little) ? bits : __builtin_bswap32(bits);
  }

  [[noreturn]] void FailTruncated(const char* what, std::size_t index) const {
    Fail(fmt::format("it ends at {} {}; it is truncated", what, index));
  }

  double Real(const char* what, std::size_t index) {
    if (binary_) {
      const auto value = static_cast<double>(std::bit_cast<float>(BinaryWord(what, index)));
      if (!std::isfinite(value))
        Fail(fmt::format("{} {} is malformed (NaN or infinity)", what, index));
      return value;
    }
    SkipToWord();
    if (at_ >= text_.size()) FailTruncated(what, index);
    return NumberOf(*NextInLine(), what, index);
  }

  std::int64_t Whole(const char* what, std::size_t index) {
    if (binary_) return static_cast<std::int32_t>(BinaryWord(what, index));
    const double value = Real(what, index);
    if (value != std::floor(value) || std::abs(value) > kMostOffCount)
      Fail(fmt::format("{} {} is malformed (a number is not whole)", what, index));
    return static_cast<std::int64_t>(value);
  }

  // --- header ---

  std::int64_t HeaderNumber() {
    if (binary_ && text_.size() - at_ < 4) Fail("its header is malformed");
    if (!binary_) {
      SkipToWord();
      double value = 0;
      const auto word = NextInLine();
      if (!word || !IsNumberWord(*word, &value) || value != std::floor(value) || value < 0 ||
          value > kMostOffCount)
        Fail("its header is malformed (it begins with the numbers of vertices, faces and edges)");
      return static_cast<std::int64_t>(value);
    }
    return static_cast<std::int32_t>(BinaryWord("header", 0));
  }

  void ReadCounts() {
    const std::size_t begin = at_;
    TakeCounts();
    if (binary_ && !CanHold()) {  // some programs write the order of their machine
      at_ = begin;
      little_ = true;
      TakeCounts();
      if (!CanHold()) {
        at_ = begin;
        little_ = false;
        TakeCounts();
      }
    }
    if (!CanHold())
      Fail(
          fmt::format("it claims {} vertices and {} faces, more than its {} bytes can hold; it is "
                      "truncated or damaged",
                      vertices_, faces_, text_.size()));
    if (dimensions_ != 3)
      Fail(fmt::format("its vertices have {} dimensions, and 3 are read", dimensions_));
  }

  void TakeCounts() {
    dimensions_ = kind_.dimension ? HeaderNumber() : 3;
    vertices_ = static_cast<std::size_t>(HeaderNumber());
    const std::size_t before = at_;
    faces_ = static_cast<std::size_t>(HeaderNumber());
    if (binary_) {
      HeaderNumber();
      return;
    }
    // The number of edges is often left out where the two others stand in one line.
    const std::size_t last = at_;
    if (NextInLine()) return;
    at_ = last;
    if (std::string_view(text_).substr(before, last - before).find_first_of("\r\n") != text_.npos)
      HeaderNumber();
  }

  /// The shortest vertex is "0 0 0", the shortest face "0", each with its line end.
  bool CanHold() const { return vertices_ <= text_.size() / 6 && faces_ <= text_.size() / 2; }

  // --- vertices ---

  std::size_t PlainNumbers() const {
    return 3 + kind_.weight + (kind_.normal ? 3 : 0) + (kind_.texture ? 2 : 0);
  }

  void ReadVertices() {
    const auto rows = static_cast<Eigen::Index>(vertices_);
    mesh_ = {};
    mesh_.points.resize(rows, 3);
    if (kind_.normal) mesh_.normals.resize(rows, 3);
    if (kind_.texture) mesh_.uvs.resize(rows, 2);
    const bool lines = !binary_ && !other_way_ && vertices_ > 0 && FirstLineIsWhole();
    std::vector<std::string_view> words;
    for (std::size_t v = 0; v < vertices_; ++v) {
      if (lines) {
        TakeLine(v, &words);
        PutVertex(v, words);
      } else {
        ReadSpreadVertex(v);
      }
    }
  }

  /// Whether the first vertex has a line of its own, so that all have one.
  bool FirstLineIsWhole() {
    const std::size_t begin = at_;
    SkipToWord();
    std::size_t count = 0;
    while (NextInLine()) ++count;
    at_ = begin;
    return count >= PlainNumbers();
  }

  void TakeLine(std::size_t v, std::vector<std::string_view>* words) {
    SkipToWord();
    if (at_ >= text_.size()) FailTruncated("vertex", v);
    words->clear();
    while (const auto word = NextInLine()) words->push_back(*word);
    const std::size_t plain = PlainNumbers(), given = words->size();
    const std::size_t color = given < plain ? 0 : given - plain;
    if (given < plain)
      Fail(fmt::format("vertex {} has {} numbers, and {} says {}", v, given, keyword_, plain));
    if (!kind_.color && color > 0)
      Fail(
          fmt::format("vertex {} has {} numbers, and {} says {}: files with normals begin with "
                      "NOFF, with colours COFF",
                      v, given, keyword_, plain));
    if (color == 2 || color > 4)
      Fail(fmt::format("vertex {} has {} numbers for its colour; it may have 1, 3 or 4", v, color));
  }

  /// @param words  of the vertex's line
  void PutVertex(std::size_t v, const std::vector<std::string_view>& words) {
    std::array<double, 13> numbers{};
    for (std::size_t i = 0; i < words.size(); ++i) numbers[i] = NumberOf(words[i], "vertex", v);
    const std::size_t before = 3 + kind_.weight + (kind_.normal ? 3 : 0),
                      color = words.size() - PlainNumbers();
    PutPlain(v, numbers.data(), numbers.data() + words.size() - 2);
    bool whole = true;
    for (std::size_t i = before; i < before + color; ++i)
      whole &= words[i].find_first_of(".eE") == words[i].npos;
    if (color > 2) PutColor(v, numbers.data() + before, whole);
    mapped_ |= color == 1;
  }

  /// In Geomview's order, over lines as they like, or binary.
  void ReadSpreadVertex(std::size_t v) {
    std::array<double, 7> before{};
    const std::size_t count = 3 + kind_.weight + (kind_.normal ? 3 : 0);
    for (std::size_t i = 0; i < count; ++i) before[i] = Real("vertex", v);
    if (kind_.color) ReadSpreadColor(v);
    std::array<double, 2> uv{};
    if (kind_.texture) uv = {Real("vertex", v), Real("vertex", v)};
    PutPlain(v, before.data(), uv.data());
  }

  void ReadSpreadColor(std::size_t v) {
    const std::int64_t count = binary_ && other_way_ ? Whole("vertex", v) : 4;
    if (count < 0 || count > 4 || count == 2)
      Fail(fmt::format("vertex {} has {} numbers for its colour", v, count));
    std::array<double, 4> color{};
    for (std::int64_t i = 0; i < count; ++i) color[static_cast<std::size_t>(i)] = Real("vertex", v);
    if (count > 2) PutColor(v, color.data(), false);
    mapped_ |= count == 1;
  }

  void PutPlain(std::size_t v, const double* numbers, const double* uv) {
    const auto row = static_cast<Eigen::Index>(v);
    const double w = kind_.weight ? numbers[3] : 1;
    if (w == 0) Fail(fmt::format("vertex {} lies at infinity (its fourth coordinate is 0)", v));
    mesh_.points.row(row) << numbers[0] / w, numbers[1] / w, numbers[2] / w;
    if (kind_.normal)
      for (int k = 0; k < 3; ++k) mesh_.normals(row, k) = numbers[3 + kind_.weight + k];
    if (kind_.texture) mesh_.uvs.row(row) << uv[0], uv[1];
  }

  void PutColor(std::size_t v, const double* numbers, bool whole) {
    colored_.push_back(v);
    vertex_colors_.push_back({{numbers[0], numbers[1], numbers[2]}, whole});
  }

  // --- faces ---

  void ReadFace(std::size_t f) {
    const std::int64_t count = Whole("face", f);
    if (count < 0 || count > static_cast<std::int64_t>(text_.size() / 2))
      Fail(fmt::format("face {} claims {} corners, which the file cannot hold", f, count));
    for (std::int64_t k = 0; k < count; ++k) {
      const std::int64_t corner = Whole("face", f);
      if (corner < 0 || corner >= static_cast<std::int64_t>(vertices_))
        Fail(fmt::format("face {} names vertex {}, but the file has {}", f, corner, vertices_));
      corners_.push_back(static_cast<int>(corner));
    }
    sizes_.push_back(static_cast<std::size_t>(count));
    color_of_face_.push_back(-1);
    if (binary_)
      ReadBinaryFaceColor(f);
    else
      ReadFaceColor(f);
  }

  void ReadFaceColor(std::size_t f) {
    std::array<double, 4> numbers{};
    std::size_t count = 0;
    bool whole = true;
    for (auto word = NextInLine(); word; word = NextInLine(), ++count) {
      if (count == 4) Fail(fmt::format("face {} has more than four numbers for its colour", f));
      numbers[count] = NumberOf(*word, "face", f);
      whole &= word->find_first_of(".eE") == word->npos;
    }
    PutFaceColor(f, numbers.data(), count, whole);
  }

  void ReadBinaryFaceColor(std::size_t f) {
    const std::int64_t count = Whole("face", f);
    if (count < 0 || count > 4)
      Fail(fmt::format("face {} has {} numbers for its colour", f, count));
    std::array<double, 4> numbers{};
    for (std::int64_t i = 0; i < count; ++i) numbers[static_cast<std::size_t>(i)] = Real("face", f);
    PutFaceColor(f, numbers.data(), static_cast<std::size_t>(count), false);
  }

  void PutFaceColor(std::size_t f, const double* numbers, std::size_t count, bool whole) {
    if (count == 2)
      Fail(fmt::format("face {} has 2 numbers for its colour; it may have 1, 3 or 4", f));
    mapped_ |= count == 1;
    if (count < 3) return;
    color_of_face_.back() = static_cast<int>(face_colors_.size());
    face_colors_.push_back({{numbers[0], numbers[1], numbers[2]}, whole});
  }

  /// More than the header says: its counts are wrong.
  void RequireEnd() {
    const std::string_view rest = std::string_view(text_).substr(at_);
    if (!binary_) SkipToWord();
    const bool ends = binary_ ? std::all_of(rest.begin(), rest.end(), IsOffSpace)
                              : at_ >= text_.size() || text_[at_] == '\x1a' || text_[at_] == '\0';
    if (!ends)
      Fail(
          fmt::format("it goes on after its {} vertices and {} faces; its counts are not those of "
                      "its data",
                      vertices_, faces_));
  }

  // --- the mesh ---

  NotedMesh Take() {
    const Eigen::Index rows = mesh_.points.rows();
    Fan fan(path_, rows);
    std::vector<int> face_of_triangle;
    std::size_t at = 0;
    for (std::size_t f = 0; f < sizes_.size(); ++f) {
      fan.Add(corners_.data() + at, sizes_[f]);
      at += sizes_[f];
      for (std::size_t k = 2; k < sizes_[f]; ++k) face_of_triangle.push_back(static_cast<int>(f));
    }
    mesh_.faces = fan.Take();
    if (std::any_of(sizes_.begin(), sizes_.end(), [](std::size_t size) { return size > 3; }))
      PolygonCuts(mesh_.points, corners_, sizes_).Apply(corners_, &mesh_.faces);
    if (kind_.texture) mesh_.uv_faces = mesh_.faces;
    NotedMesh noted;
    if (!vertex_colors_.empty())
      mesh_.colors = ColorsOfSome(colored_, Fractions(vertex_colors_), mesh_.faces, rows);
    else if (!face_colors_.empty() && TakeFaceColors(LevelsOf(face_of_triangle), &mesh_))
      noted.notes.push_back(kColorsBlend);
    if (mapped_) noted.notes.push_back("colours that are numbers of a colour map are left out");
    noted.mesh = std::move(mesh_);
    return noted;
  }

  Eigen::MatrixX3d LevelsOf(const std::vector<int>& face_of_triangle) const {
    const std::vector<Eigen::Vector3d> colors = Fractions(face_colors_);
    Eigen::MatrixX3d levels = Eigen::MatrixX3d::Constant(std::ssize(face_of_triangle), 3,
                                                         std::numeric_limits<double>::quiet_NaN());
    for (std::size_t t = 0; t < face_of_triangle.size(); ++t) {
      const int color = color_of_face_[static_cast<std::size_t>(face_of_triangle[t])];
      if (color < 0) continue;
      levels.row(static_cast<Eigen::Index>(t)) =
          255 * colors[static_cast<std::size_t>(color)].transpose();
    }
    return levels;
  }

  const fs::path& path_;
  std::string text_;
  std::size_t at_ = 0;
  OffKind kind_;
  std::string keyword_;
  bool binary_ = false, little_ = false;
  /// Colours of vertices may be written in two ways: in binary files with a count (CGAL) or without
  /// (Geomview), in texts a vertex a line or not.
  bool other_way_ = false;
  std::int64_t dimensions_ = 3;
  std::size_t vertices_ = 0, faces_ = 0;
  Mesh mesh_;
  std::vector<std::size_t> colored_;  // vertices with colours
  std::vector<OffColor> vertex_colors_, face_colors_;
  std::vector<int> corners_, color_of_face_;
  std::vector<std::size_t> sizes_;
  bool mapped_ = false;  // a colour was the number of one
};

}  // namespace

bool LooksLikeOff(std::string_view head) {
  return KindOf(WordFrom(head, FirstWord(head))).has_value();
}

NotedMesh ReadOff(const fs::path& path) { return OffFileReader(path).Read(); }

}  // namespace keypose
