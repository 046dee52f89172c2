#include "core/io/meshes/mesh_io.h"

#define TINYOBJLOADER_USE_DOUBLE
#include <CGAL/IO/OFF/File_scanner_OFF.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>
#include <tiny_obj_loader.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/io/meshes/ply_mesh.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;
using Point = CGAL::Simple_cartesian<double>::Point_3;

namespace {

/// Reads a number at `at` like strtod, but most numbers much faster. Returns nullptr when there is
/// no number or it is not finite.
const char* TakeNumber(const char* at, const char* end, double& value) {
  while (at < end && (*at == ' ' || *at == '\t')) ++at;
  const auto [rest, error] = std::from_chars(at, end, value);
  if (error == std::errc() && std::isfinite(value)) return rest;
  char* stop = nullptr;  // e.g. for a plus sign
  value = std::strtod(at, &stop);
  return stop == at || stop > end || !std::isfinite(value) ? nullptr : stop;
}

/// Joins lines that end in a backslash with the next one, because the OBJ library does not. The
/// removed line ends are put after the joined line, so that the lines below keep their numbers.
std::string WithWholeLines(std::string text) {
  if (text.find('\\') == std::string::npos) return text;
  std::string whole;
  whole.reserve(text.size());
  std::size_t taken = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    std::size_t end = at;
    if (text[at] == '\\') end += text.compare(at + 1, 2, "\r\n") == 0 ? 2 : 1;
    if (end > at && end < text.size() && text[end] == '\n') {
      whole += ' ';
      ++taken;
      at = end;
    } else {
      whole += text[at];
      if (text[at] == '\n') whole.append(std::exchange(taken, 0), '\n');
    }
  }
  return whole;
}

/// Appends three numbers, or fewer if there are not so many. @return where they end; nullptr then
const char* TakeThree(const char* at, const char* end, std::vector<double>& numbers) {
  for (int k = 0; k < 3; ++k) {
    double value = 0;
    if (at = TakeNumber(at, end, value); !at) return nullptr;
    numbers.push_back(value);
  }
  return at;
}

/// Checks the text of the positions: the OBJ library reads 'nan', 'inf' and words as 0, which would
/// hide damage. And reads the colours that may follow them (v x y z r g b), which the library
/// skips.
/// @return three numbers a vertex; another count where a vertex has no colour
std::vector<double> CheckedColors(const fs::path& path, const std::string& text) {
  int number = 0;
  std::vector<double> position, colors;
  for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    ++number;
    if (end - begin < 2 || text[begin] != 'v' ||
        (text[begin + 1] != ' ' && text[begin + 1] != '\t'))
      continue;
    const char* const stop = text.data() + end;
    position.clear();
    const char* at = TakeThree(text.data() + begin + 1, stop, position);
    if (!at)
      throw InputError(fmt::format(
          "{}:{}: '{}' is not a vertex with three finite numbers (NaN or infinity?); repair the "
          "file and export it again",
          path.string(), number, text.substr(begin, std::min<std::size_t>(60, end - begin))));
    if (at < stop && *at != '\r') TakeThree(at, stop, colors);
  }
  return colors;
}

/// Colours from 0 to 1, as most programs write them, or else from 0 to 255.
ColorsX3 ColorsFrom(const std::vector<double>& numbers, Eigen::Index vertices) {
  if (numbers.empty() || std::ssize(numbers) != 3 * vertices) return {};
  const double scale = *std::max_element(numbers.begin(), numbers.end()) > 1 ? 1 : 255;
  ColorsX3 colors(vertices, 3);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    colors.data()[i] =
        static_cast<std::uint8_t>(std::lround(std::clamp(scale * numbers[i], 0.0, 255.0)));
  return colors;
}

/// The callbacks of the OBJ library. They are used because its ready-made arrays count a polygon's
/// corners in one byte.
class ObjCollector {
 public:
  explicit ObjCollector(const fs::path& path) : path_(path) {}

  void Read(std::istream& in) {
    tinyobj::callback_t calls;
    calls.vertex_cb = [](void* self, double x, double y, double z, double) {
      Of(self).Put(Of(self).points_, {x, y, z});
    };
    calls.texcoord_cb = [](void* self, double u, double v, double) {
      Of(self).Put(Of(self).uvs_, {u, v});
    };
    calls.index_cb = [](void* self, tinyobj::index_t* corners, int count) {
      Of(self).AddFace(corners, count);
    };
    std::string warning, error;
    const bool read = tinyobj::LoadObjWithCallback(in, calls, this, nullptr, &warning, &error);
    if (!read || !error.empty())
      throw InputError("cannot read OBJ file " + path_.string() + ": " +
                       (error.empty() ? "malformed" : error));
  }

  Mesh Take() const {
    Mesh mesh;
    mesh.points = Eigen::Map<const PointsX3>(points_.data(),
                                             static_cast<Eigen::Index>(points_.size() / 3), 3);
    mesh.faces = Fanned(corners_, mesh.points.rows());
    TakeUvs(mesh);
    return mesh;
  }

 private:
  static ObjCollector& Of(void* self) { return *static_cast<ObjCollector*>(self); }

  void Put(std::vector<double>& values, std::initializer_list<double> more) {
    values.insert(values.end(), more);
  }

  /// Corners without texture coordinates get (0, 0) where others have some.
  void TakeUvs(Mesh& mesh) const {
    const auto none = std::count(uv_corners_.begin(), uv_corners_.end(), kNone);
    if (uvs_.empty() || none == std::ssize(uv_corners_)) return;
    const auto given = static_cast<Eigen::Index>(uvs_.size() / 2);
    mesh.uvs = UvsX2::Zero(given + (none > 0), 2);
    mesh.uvs.topRows(given) = Eigen::Map<const UvsX2>(uvs_.data(), given, 2);
    std::vector<int> corners = uv_corners_;
    std::replace(corners.begin(), corners.end(), kNone, static_cast<int>(given));
    mesh.uv_faces = Fanned(corners, mesh.uvs.rows());
  }

  /// An index counted from 0. In the file, indices count from 1, or backwards from the last element
  /// before the face.
  static int FromZero(int index, std::size_t so_far) {
    return index > 0 ? index - 1 : index + static_cast<int>(so_far);
  }

  void AddFace(const tinyobj::index_t* corners, int count) {
    for (int k = 0; k < count; ++k) {
      if (corners[k].vertex_index == 0)
        throw InputError(
            fmt::format("{}: face {} has a corner that names no vertex (they count from 1)",
                        path_.string(), sizes_.size()));
      corners_.push_back(FromZero(corners[k].vertex_index, points_.size() / 3));
      uv_corners_.push_back(corners[k].texcoord_index == 0
                                ? kNone
                                : FromZero(corners[k].texcoord_index, uvs_.size() / 2));
    }
    sizes_.push_back(static_cast<std::size_t>(count));
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

  static constexpr int kNone = std::numeric_limits<int>::min();
  const fs::path& path_;
  std::vector<double> points_, uvs_;       // 3 and 2 a vertex
  std::vector<int> corners_, uv_corners_;  // of all faces, concatenated
  std::vector<std::size_t> sizes_;         // corners of each face
};

Mesh ReadObjMesh(const fs::path& path) {
  std::string text = WithWholeLines(ReadFile(path));
  const std::vector<double> colors = CheckedColors(path, text);
  std::istringstream in(std::move(text));
  ObjCollector collector(path);
  collector.Read(in);
  Mesh mesh = collector.Take();
  mesh.colors = ColorsFrom(colors, mesh.points.rows());
  return mesh;
}

template <class Polygons>
Mesh FromSoup(const fs::path& path, const std::vector<Point>& points, const Polygons& polygons) {
  Mesh mesh;
  mesh.points.resize(std::ssize(points), 3);
  for (std::size_t v = 0; v < points.size(); ++v)
    mesh.points.row(v) << points[v].x(), points[v].y(), points[v].z();
  Fan fan(path, mesh.points.rows());
  for (const auto& polygon : polygons) fan.Add(polygon.data(), polygon.size());
  mesh.faces = fan.Take();
  return mesh;
}

/// Reads OFF with CGAL's scanner, not with CGAL's own reader: no number of the header or of a face
/// may exceed what the rest of the file can hold.
class OffReader {
 public:
  explicit OffReader(const fs::path& path)
      : path_(path), bytes_(fs::file_size(path)), in_(path, std::ios::binary), scanner_(in_) {
    if (!in_) Fail("its header is malformed");
    // The shortest vertex is "0 0 0", the shortest face "0", each with its line end.
    if (scanner_.size_of_vertices() > bytes_ / 6 || scanner_.size_of_facets() > bytes_ / 2)
      Fail(
          fmt::format("it claims {} vertices and {} faces, more than its {} bytes can hold; it is "
                      "truncated or damaged",
                      scanner_.size_of_vertices(), scanner_.size_of_facets(), bytes_));
  }

  Mesh Read() {
    Mesh mesh;
    mesh.points.resize(static_cast<Eigen::Index>(scanner_.size_of_vertices()), 3);
    for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) ReadVertex(v, mesh.points);
    Fan fan(path_, mesh.points.rows());
    std::vector<std::size_t> corners;
    for (std::size_t f = 0; f < scanner_.size_of_facets(); ++f) {
      ReadFace(f, corners);
      fan.Add(corners.data(), corners.size());
    }
    mesh.faces = fan.Take();
    return mesh;
  }

 private:
  [[noreturn]] void Fail(const std::string& why) const {
    throw InputError("cannot read OFF file " + path_.string() + ": " + why);
  }

  void ReadVertex(Eigen::Index v, PointsX3& points) {
    double x = 0, y = 0, z = 0, w = 1;
    scanner_.scan_vertex(x, y, z, w);
    if (scanner_.binary())
      scanner_.skip_to_next_vertex(
          static_cast<std::size_t>(v));  // the file has at least one line of text for each
    if (!in_ && !in_.eof()) Fail(fmt::format("vertex {} is malformed", v));
    if (in_.eof() && scanner_.size_of_facets() > 0)
      Fail(fmt::format("it ends at vertex {}; it is truncated", v));
    if (w == 0) Fail(fmt::format("vertex {} lies at infinity (its fourth coordinate is 0)", v));
    points.row(v) << x / w, y / w, z / w;
  }

  void ReadFace(std::size_t f, std::vector<std::size_t>& corners) {
    std::size_t count = 0;
    scanner_.scan_facet(count, f);
    if (!in_ && !in_.eof()) Fail(fmt::format("face {} is malformed", f));
    if (count > bytes_ / 2)
      Fail(fmt::format("face {} claims {} corners, which the file cannot hold", f,
                       static_cast<std::int64_t>(count)));
    corners.assign(count, 0);
    for (std::size_t k = 0; k < count; ++k) {
      scanner_.scan_facet_vertex_index(corners[k], k + 1, f);
      if (!in_) Fail(fmt::format("it ends or is malformed at face {}", f));
    }
    if (!scanner_.binary()) return;
    scanner_.skip_to_next_facet(f);
    if (!in_) Fail(fmt::format("it ends or is malformed at face {}", f));
  }

  const fs::path& path_;
  std::uintmax_t bytes_;
  std::ifstream in_;
  CGAL::File_scanner_OFF scanner_;
};

Mesh ReadOffMesh(const fs::path& path) { return OffReader(path).Read(); }

Mesh ReadStlMesh(const fs::path& path) {
  std::vector<Point> points;
  std::vector<std::array<int, 3>> triangles;
  std::ifstream in(path, std::ios::binary);
  if (!CGAL::IO::read_STL(in, points, triangles))
    throw InputError("cannot read STL file " + path.string() + ": it is malformed or truncated");
  return FromSoup(path, points, triangles);
}

bool LooksLikeBinaryStl(const fs::path& path, const std::string& head) {
  if (head.size() < 84) return false;
  std::uint32_t triangles = 0;
  std::memcpy(&triangles, head.data() + 80, 4);
  return fs::file_size(path) == 84 + std::uint64_t{50} * triangles;
}

/// Whether it begins with a keyword such as OFF, COFF or STNOFF; `o coffee cup` of an OBJ does not.
/// @param start  in capitals
bool LooksLikeOff(const std::string& start) {
  const std::size_t at = start.find("OFF");
  return at < 5 && start.find_first_not_of("STCN4") >= at;
}

/// What a file is that other programs call a mesh, for messages; "" if that is not known.
std::string OtherMeshKind(std::string_view head) {
  constexpr std::pair<std::string_view, const char*> kStarts[] = {
      {"glTF", "a binary glTF (.glb)"},
      {"Kaydara FBX", "an FBX file"},
      {"; FBX", "an FBX file"},
      {"PK\x03\x04", "a ZIP file, as .usdz and .3mf are"},
      {"#usda", "a USD file"},
      {"PXR-USDC", "a USD file"},
      {"BLENDER", "a Blender file"},
      {"Ogawa", "an Alembic file"},
      {"<?xml", "an XML file, as Collada's .dae is"}};
  for (const auto& [start, kind] : kStarts)
    if (head.starts_with(start)) return kind;
  if (head.starts_with("{") && head.find("\"asset\"") != head.npos) return "a glTF file";
  return "";
}

bool LooksLikeObj(const std::string& head) {
  std::istringstream in(head);
  for (std::string line; std::getline(in, line);) {
    std::istringstream words(line);
    std::string first;
    if (!(words >> first) || first[0] == '#') continue;
    for (const char* key : {"v", "vn", "vt", "f", "o", "g", "s", "mtllib", "usemtl", "l", "p"})
      if (first == key) return true;
    return false;
  }
  return true;  // comments only: an OBJ without vertices
}

}  // namespace

Mesh ReadMesh(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("mesh " + path.string() + " does not exist");
  if (!fs::is_regular_file(path)) throw DiskError("mesh " + path.string() + " is not a file");
  std::ifstream in(path, std::ios::binary);
  if (!in) throw DiskError("cannot open mesh " + path.string());
  std::string head(4096, '\0');
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(in.gcount()));
  in.close();
  if (head.empty()) throw InputError("mesh " + path.string() + " is empty (0 bytes)");
  const auto next_word = [&head](std::size_t from) {
    return std::min(head.find_first_not_of(" \t\r\n\xef\xbb\xbf", from), head.size());
  };
  std::size_t word = next_word(0);
  while (word < head.size() && head[word] == '#')
    word = next_word(std::min(head.find('\n', word), head.size()));
  std::string start = head.substr(word, 8);
  std::transform(start.begin(), start.end(), start.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (start.rfind("PLY", 0) == 0) return ReadPlyMesh(path);
  if (LooksLikeOff(start)) return ReadOffMesh(path);
  if (start.rfind("SOLID", 0) == 0 || LooksLikeBinaryStl(path, head)) return ReadStlMesh(path);
  if (const std::string kind = OtherMeshKind(head); !kind.empty())
    throw InputError(path.string() + " is " + kind +
                     "; meshes are read from PLY, OBJ, OFF and STL: open it in Blender and export "
                     "it as OBJ (Wavefront)");
  if (LooksLikeObj(head)) return ReadObjMesh(path);
  throw InputError(path.string() +
                   " is not a PLY, OBJ, OFF or STL mesh (judged by its first bytes)");
}

PointCloud ReadPointCloud(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("point cloud " + path.string() + " does not exist");
  if (!fs::is_regular_file(path))
    throw DiskError("point cloud " + path.string() + " is not a file");
  return ReadPlyCloud(path);
}

}  // namespace keypose
