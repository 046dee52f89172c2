#include "core/io/meshes/obj_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <string_view>
#include <utility>

#include "core/io/meshes/polygon_cut.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/io/meshes/some_colors.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace {

namespace fs = std::filesystem;

/// Joins lines that end in a backslash with the next one. The removed line ends are put after the
/// joined line, so that the lines below keep their numbers. Comments are not continued: Windows
/// paths in them may end in a backslash. Lines that end with \r alone get a \n.
class WholeLines {
 public:
  explicit WholeLines(std::string text) : text_(std::move(text)) {}

  std::string Take() {
    if (text_.find('\n') == std::string::npos) std::replace(text_.begin(), text_.end(), '\r', '\n');
    if (text_.find('\\') == std::string::npos) return std::move(text_);
    whole_.reserve(text_.size());
    while (at_ < text_.size()) TakeLine();
    return std::move(whole_);
  }

 private:
  void TakeLine() {
    const std::size_t end = std::min(text_.find('\n', at_), text_.size());
    std::string_view line(text_.data() + at_, end - at_);
    at_ = end + 1;
    if (taken_ == 0) comment_ = line.starts_with('#');
    const std::size_t last = line.find_last_not_of('\r');
    const bool continued = !comment_ && last != line.npos && line[last] == '\\';
    if (continued && end < text_.size()) {
      whole_ += line.substr(0, last);
      whole_ += ' ';
      ++taken_;
      return;
    }
    whole_ += line;
    if (end < text_.size()) whole_.append(1 + std::exchange(taken_, 0), '\n');
  }

  std::string text_, whole_;
  std::size_t at_ = 0, taken_ = 0;
  bool comment_ = false;
};

bool IsSpace(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f'; }

/// The words of a line, up to a comment.
class ObjWords {
 public:
  explicit ObjWords(std::string_view line) : line_(line) {}

  /// Empty: there is no more.
  std::string_view Next() {
    while (at_ < line_.size() && IsSpace(line_[at_])) ++at_;
    const std::size_t begin = at_;
    if (begin < line_.size() && line_[begin] == '#') at_ = line_.size();
    if (at_ > begin) return {};
    while (at_ < line_.size() && !IsSpace(line_[at_])) ++at_;
    return line_.substr(begin, at_ - begin);
  }

  /// The rest of the line, without spaces at its ends. May hold '#'.
  std::string Rest() const {
    std::size_t begin = at_, end = line_.size();
    while (begin < end && IsSpace(line_[begin])) ++begin;
    while (end > begin && IsSpace(line_[end - 1])) --end;
    return std::string(line_.substr(begin, end - begin));
  }

 private:
  std::string_view line_;
  std::size_t at_ = 0;
};

/// @return whether the word is a whole, finite number
bool TakeNumber(std::string_view word, double* value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const char* const stop = word.data() + word.size();
  const auto [end, error] = std::from_chars(word.data(), stop, *value);
  if (error == std::errc::result_out_of_range && end == stop)  // too small, or too large
    *value = std::strtod(std::string(word).c_str(), nullptr);
  else if (error != std::errc())
    return false;
  return end == stop && std::isfinite(*value);
}

class ObjReader {
 public:
  explicit ObjReader(const fs::path& path) : path_(path) {}

  ObjFile Read() {
    const std::string text = WholeLines(ReadFile(path_)).Take();
    for (std::size_t begin = 0; begin < text.size();) {
      const std::size_t end = std::min(text.find('\n', begin), text.size());
      ++line_number_;
      line_ = std::string_view(text).substr(begin, end - begin);
      TakeLine();
      begin = end + 1;
    }
    return Take();
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError(fmt::format("{}:{}: '{}' {}", path_.string(), line_number_,
                                 WithoutOddBytes(std::string(line_.substr(0, 60))), why));
  }

  void TakeLine() {
    if (line_.starts_with("#MRGB")) return TakePolypaint();
    if (line_number_ == 1 && line_.starts_with("\xef\xbb\xbf")) line_.remove_prefix(3);
    ObjWords words(line_);
    const std::string_view key = words.Next();
    if (key == "v") return TakeVertex(&words);
    if (key == "vt") return TakeUv(&words);
    if (key == "f" || key == "fo") return TakeFace(&words);
    if (key == "usemtl") return TakeMaterial(words.Rest());
    if (key == "mtllib") return file_.libraries.push_back(words.Rest());
    if (key == "vc") return TakeVertexColor(&words);
    if (key == "usemap" && words.Rest() != "off") file_.has_texture_maps = true;
    RequireRead(key);
    NoteUnknown(key);
  }

  /// What no program of today writes and no specification has is said, a few times.
  void NoteUnknown(std::string_view key) {
    constexpr std::array<std::string_view, 33> kSkipped = {
        "",          "vn",    "vp",       "p",      "l",        "curv",   "curv2",
        "cstype",    "deg",   "bmat",     "step",   "parm",     "trim",   "hole",
        "scrv",      "sp",    "end",      "con",    "g",        "s",      "mg",
        "o",         "bevel", "c_interp", "lod",    "d_interp", "maplib", "shadow_obj",
        "trace_obj", "ctech", "stech",    "usemap", "vt"};
    if (std::find(kSkipped.begin(), kSkipped.end(), key) != kSkipped.end()) return;
    const std::string note = fmt::format("its lines '{}' are not known and were left out",
                                         WithoutOddBytes(std::string(key.substr(0, 40))));
    constexpr std::size_t kMostNotes = 3;
    if (file_.left_out.size() < kMostNotes &&
        std::find(file_.left_out.begin(), file_.left_out.end(), note) == file_.left_out.end())
      file_.left_out.push_back(note);
  }

  void TakeVertexColor(ObjWords* words) {
    Eigen::Vector3d color;
    for (int k = 0; k < 3; ++k)
      if (!TakeNumber(words->Next(), &color[k]))
        Fail("is not a colour with three finite numbers; repair the file and export it again");
    listed_colors_.push_back(color);
  }

  /// What would change the surface if it were skipped.
  void RequireRead(std::string_view key) const {
    for (const char* surface : {"surf", "bzp", "bsp", "cdc", "cdp", "res"})
      if (key == surface)
        Fail(
            "is a free-form surface, which is not read: convert it to polygons in the program that "
            "made it");
    if (key == "call" || key == "csh")
      Fail("takes a part of the mesh from elsewhere, which is not done: export it as one file");
  }

  /// What programs write for a vertex that no picture coloured.
  static bool IsNotANumber(std::string_view word) {
    if (word.starts_with('-')) word.remove_prefix(1);
    return word.starts_with("nan") || word.starts_with("NaN") || word.starts_with("NAN");
  }

  void TakeVertex(ObjWords* words) {
    std::array<double, 8> numbers{};
    std::size_t count = 0;
    bool uncolored = false;
    for (std::string_view word = words->Next(); !word.empty(); word = words->Next()) {
      if (count == numbers.size()) FailVertex();
      const bool number = TakeNumber(word, &numbers[count]);
      if (!number && (count < 3 || !IsNotANumber(word))) FailVertex();
      uncolored |= !number;
      ++count;
    }
    if (count < 3) FailVertex();
    if (count == 5 || count == 8)
      Fail(
          fmt::format("has {} numbers; a vertex has 3, with a weight 4, with a colour 6, with both "
                      "7",
                      count));
    points_.insert(points_.end(), numbers.begin(), numbers.begin() + 3);
    if (count < 6 || uncolored) return;
    colored_.push_back(points_.size() / 3 - 1);
    // Of seven, which of the first and last is no colour is known at the end.
    const bool both = count == 7;
    extra_.push_back({numbers[3], numbers[4], numbers[5], both ? numbers[6] : NAN});
  }

  [[noreturn]] void FailVertex() const {
    const bool comma = line_.find(',') != line_.npos;
    Fail(comma
             ? "is not a vertex with three finite numbers: it has commas; export it with points "
               "as decimal marks"
             : "is not a vertex with three finite numbers (NaN or infinity?); repair the file and "
               "export it again");
  }

  void TakeUv(ObjWords* words) {
    std::array<double, 2> uv{};
    for (std::size_t k = 0; k < 2; ++k) {
      const std::string_view word = words->Next();
      if (k > 0 && word.empty()) break;  // of a texture of one dimension
      if (!TakeNumber(word, &uv[k]))
        Fail(
            "is not a texture coordinate with finite numbers; repair the file and export it again");
    }
    uvs_.insert(uvs_.end(), uv.begin(), uv.end());
  }

  /// An index counted from 0. In the file, indices count from 1, or backwards from the last element
  /// before the face.
  int FromZero(std::string_view digits, std::size_t so_far, const char* what) const {
    if (digits.starts_with('+')) digits.remove_prefix(1);
    long long index = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (error != std::errc() || end != digits.data() + digits.size())
      Fail(fmt::format("has a corner whose {} is no number", what));
    if (index == 0) Fail(fmt::format("has a corner that names no {} (they count from 1)", what));
    const long long from_zero = index > 0 ? index - 1 : index + static_cast<long long>(so_far);
    if (from_zero < 0 || from_zero > std::numeric_limits<int>::max())
      Fail(fmt::format("names the {} {}, which the file does not have", what, index));
    return static_cast<int>(from_zero);
  }

  void TakeFace(ObjWords* words) {
    std::size_t count = 0;
    for (std::string_view word = words->Next(); !word.empty(); word = words->Next()) {
      const std::size_t slash = std::min(word.find('/'), word.size());
      corners_.push_back(FromZero(word.substr(0, slash), points_.size() / 3, "vertex"));
      std::string_view uv = word.substr(std::min(slash + 1, word.size()));
      uv = uv.substr(0, uv.find('/'));
      TakeCornerColor(word);
      uv_corners_.push_back(uv.empty() ? kNone
                                       : FromZero(uv, uvs_.size() / 2, "texture coordinate"));
      ++count;
    }
    sizes_.push_back(count);
    if (material_ < 0) TakeMaterial("");
    for (std::size_t k = 2; k < count; ++k) file_.material_of_face.push_back(material_);
  }

  /// The number behind a corner's third slash is that of a `vc`.
  void TakeCornerColor(std::string_view word) {
    if (listed_colors_.empty() || std::count(word.begin(), word.end(), '/') != 3) return;
    word.remove_prefix(word.rfind('/') + 1);
    if (!word.empty())
      corner_colors_.emplace_back(corners_.back(),
                                  FromZero(word, listed_colors_.size(), "colour (vc)"));
  }

  void TakeMaterial(const std::string& name) {
    const auto found = std::find(file_.materials.begin(), file_.materials.end(), name);
    material_ = static_cast<int>(found - file_.materials.begin());
    if (found == file_.materials.end()) file_.materials.push_back(name);
  }

  /// ZBrush: eight digits a vertex: a mask, then red, green, blue.
  void TakePolypaint() {
    std::string_view digits = line_.substr(5);
    while (!digits.empty() && IsSpace(digits.front())) digits.remove_prefix(1);
    for (; digits.size() >= 8; digits.remove_prefix(8)) {
      std::uint32_t color = 0;
      const auto [end, error] = std::from_chars(digits.data(), digits.data() + 8, color, 16);
      if (error != std::errc() || end != digits.data() + 8) return;
      polypaint_.push_back({static_cast<std::uint8_t>(color >> 16),
                            static_cast<std::uint8_t>(color >> 8),
                            static_cast<std::uint8_t>(color)});
    }
  }

  ObjFile Take() {
    Mesh& mesh = file_.mesh;
    mesh.points = Eigen::Map<const PointsX3>(points_.data(),
                                             static_cast<Eigen::Index>(points_.size() / 3), 3);
    mesh.faces = Fanned(corners_, mesh.points.rows());
    const PolygonCuts cuts(mesh.points, corners_, sizes_);
    cuts.Apply(corners_, &mesh.faces);
    TakeUvs(cuts);
    TakeColors();
    TakePolygons();
    DropUnusedMaterials();
    return std::move(file_);
  }

  FacesX3 Fanned(const std::vector<int>& corners, Eigen::Index vertices) const {
    Fan fan(path_, vertices);
    std::size_t at = 0;
    for (const std::size_t size : sizes_) {
      fan.Add(corners.data() + at, size);
      at += size;
    }
    return fan.Take();
  }

  /// Corners without texture coordinates get (0, 0) where others have some.
  void TakeUvs(const PolygonCuts& cuts) {
    Mesh& mesh = file_.mesh;
    const auto none = std::count(uv_corners_.begin(), uv_corners_.end(), kNone);
    if (uvs_.empty() || none == std::ssize(uv_corners_)) return;
    const auto given = static_cast<Eigen::Index>(uvs_.size() / 2);
    mesh.uvs = UvsX2::Zero(given + (none > 0), 2);
    mesh.uvs.topRows(given) = Eigen::Map<const UvsX2>(uvs_.data(), given, 2);
    std::vector<int> corners = uv_corners_;
    std::replace(corners.begin(), corners.end(), kNone, static_cast<int>(given));
    mesh.uv_faces = Fanned(corners, mesh.uvs.rows());
    cuts.Apply(corners, &mesh.uv_faces);
  }

  /// Whether the fourth of seven numbers is the weight, as in `v x y z w r g b`. Else the last is
  /// alpha. Either is the same everywhere.
  bool HasWeightFirst() const {
    bool first = true, last = true;
    for (const auto& extra : extra_) {
      if (std::isnan(extra[3])) continue;
      first &= extra[0] == 1;
      last &= extra[3] == 1 || extra[3] == 255;
    }
    return first || !last;
  }

  void TakeColors() {
    Mesh& mesh = file_.mesh;
    if (colored_.empty() && !polypaint_.empty() && std::ssize(polypaint_) == mesh.points.rows()) {
      mesh.colors.resize(mesh.points.rows(), 3);
      for (std::size_t v = 0; v < polypaint_.size(); ++v)
        for (int c = 0; c < 3; ++c)
          mesh.colors(static_cast<Eigen::Index>(v), c) = polypaint_[v][static_cast<std::size_t>(c)];
      return;
    }
    if (!polypaint_.empty())
      file_.left_out.push_back(
          "its colours of ZBrush (#MRGB) are not as many as its vertices, and "
          "were left out");
    if (colored_.empty() && !listed_colors_.empty()) return TakeListedColors();
    const bool weight_first = HasWeightFirst();
    std::vector<Eigen::Vector3d> colors;
    for (const auto& extra : extra_) {
      const bool shifted = weight_first && !std::isnan(extra[3]);
      colors.push_back(shifted ? Eigen::Vector3d(extra[1], extra[2], extra[3])
                               : Eigen::Vector3d(extra[0], extra[1], extra[2]));
    }
    mesh.colors = ColorsOfSome(colored_, colors, mesh.faces, mesh.points.rows());
  }

  /// `vc` lines: those that the faces' corners name, else they belong to the vertices in order.
  void TakeListedColors() {
    Mesh& mesh = file_.mesh;
    const std::size_t vertices = points_.size() / 3;
    std::vector<int> color_of(vertices, -1);
    for (const auto& [vertex, color] : corner_colors_) {
      if (color >= SizeOf(listed_colors_) || vertex >= SizeOf(color_of)) {
        file_.left_out.push_back(
            "its colours (vc) are left out: a face names one that is not there");
        return;
      }
      color_of[vertex] = color;
    }
    if (corner_colors_.empty() && listed_colors_.size() == vertices)
      std::iota(color_of.begin(), color_of.end(), 0);
    std::vector<std::size_t> colored;
    std::vector<Eigen::Vector3d> colors;
    for (std::size_t v = 0; v < vertices; ++v) {
      if (color_of[v] < 0) continue;
      colored.push_back(v);
      colors.push_back(listed_colors_[color_of[v]]);
    }
    if (colored.empty())
      file_.left_out.push_back(
          fmt::format("its {} colours (vc) are left out, because it has {} vertices",
                      listed_colors_.size(), vertices));
    mesh.colors = ColorsOfSome(colored, colors, mesh.faces, mesh.points.rows());
  }

  void TakePolygons() {
    if (std::all_of(sizes_.begin(), sizes_.end(), [](std::size_t size) { return size <= 3; }))
      return;
    Polygons& polygons = file_.polygons;
    auto corner = corners_.begin();
    for (const std::size_t size : sizes_) {
      const auto end = corner + static_cast<std::ptrdiff_t>(size);
      if (size > 2) {
        polygons.sizes.push_back(static_cast<int>(size));
        polygons.corners.insert(polygons.corners.end(), corner, end);
      }
      corner = end;
    }
  }

  /// Materials of which no face is.
  void DropUnusedMaterials() {
    std::vector<int> new_index(file_.materials.size(), -1);
    std::vector<std::string> used;
    for (int& material : file_.material_of_face) {
      int& index = new_index[material];
      if (index < 0) {
        index = SizeOf(used);
        used.push_back(file_.materials[material]);
      }
      material = index;
    }
    file_.materials = std::move(used);
  }

  static constexpr int kNone = std::numeric_limits<int>::min();
  const fs::path& path_;
  ObjFile file_;
  std::string_view line_;
  std::size_t line_number_ = 0;
  int material_ = -1;
  std::vector<double> points_, uvs_;            // 3 and 2 a vertex
  std::vector<std::size_t> colored_;            // vertices with colours
  std::vector<std::array<double, 4>> extra_;    // what follows their positions; NaN: three numbers
  std::vector<Eigen::Vector3d> listed_colors_;  // of vc
  std::vector<std::pair<int, int>> corner_colors_;  // vertices, and the vc that their corners name
  std::vector<std::array<std::uint8_t, 3>> polypaint_;
  std::vector<int> corners_, uv_corners_;  // of all faces, concatenated
  std::vector<std::size_t> sizes_;         // corners of each face
};

}  // namespace

ObjFile ReadObj(const fs::path& path) { return ObjReader(path).Read(); }

}  // namespace keypose
