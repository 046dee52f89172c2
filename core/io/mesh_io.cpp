#include "core/io/mesh_io.h"

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
#include <map>
#include <sstream>
#include <utility>

#include "core/errors.h"
#include "core/io/files.h"
#include "core/io/ply_io.h"
#include "core/size_of.h"

namespace keypose {
namespace fs = std::filesystem;
using Point = CGAL::Simple_cartesian<double>::Point_3;

namespace {

/// Splits polygons into fans of triangles. Polygons with fewer than three corners are dropped.
class Fan {
 public:
  explicit Fan(const fs::path& path, std::int64_t vertex_count)
      : path_(path), vertex_count_(vertex_count) {}
  template <class Corner>
  void Add(const Corner* corners, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k) Check(corners[k]);
    for (std::size_t k = 1; k + 1 < count; ++k)
      triangles_.push_back({static_cast<int>(corners[0]), static_cast<int>(corners[k]),
                            static_cast<int>(corners[k + 1])});
    ++polygons_;
  }
  FacesX3 Take() const {
    FacesX3 faces(std::ssize(triangles_), 3);
    for (std::size_t f = 0; f < triangles_.size(); ++f)
      for (int k = 0; k < 3; ++k) faces(static_cast<Eigen::Index>(f), k) = triangles_[f][k];
    return faces;
  }

 private:
  template <class Corner>
  void Check(Corner v) const {
    // PLY may hold fractions, NaN and infinity
    const auto number = static_cast<double>(v);
    if (!(number >= 0 && number < static_cast<double>(vertex_count_)))
      throw InputError(fmt::format("{}: face {} names vertex {}, but the file has {}",
                                   path_.string(), polygons_, v, vertex_count_));
  }
  const fs::path& path_;
  std::int64_t vertex_count_;
  std::size_t polygons_ = 0;
  std::vector<std::array<int, 3>> triangles_;
};

PointsX3 ColumnsToPoints(const PlyElement& element, const std::array<const char*, 3>& names) {
  PointsX3 points(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at(names[k]);
    for (std::size_t i = 0; i < column.size(); ++i)
      points(static_cast<Eigen::Index>(i), k) = column[i];
  }
  return points;
}

ColorsX3 ColumnsToColors(const PlyElement& element) {
  const std::array<const char*, 3> names{"red", "green", "blue"};
  ColorsX3 colors(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at(names[k]);
    for (std::size_t i = 0; i < column.size(); ++i)
      colors(static_cast<Eigen::Index>(i), k) = static_cast<std::uint8_t>(
          std::lround(std::isfinite(column[i]) ? std::clamp(column[i], 0.0, 255.0) : 0.0));
  }
  return colors;
}

const PlyElement& VertexElement(const PlyTable& table, const fs::path& path) {
  const auto it = table.find("vertex");
  if (it == table.end() || !it->second.Has("x") || !it->second.Has("y") || !it->second.Has("z"))
    throw InputError(path.string() + ": the PLY file has no vertices with x, y and z");
  return it->second;
}

template <class Target>
void ReadVertexExtras(const PlyElement& vertex, Target& target) {
  if (vertex.Has("nx") && vertex.Has("ny") && vertex.Has("nz"))
    target.normals = ColumnsToPoints(vertex, {"nx", "ny", "nz"});
  if (vertex.Has("red") && vertex.Has("green") && vertex.Has("blue"))
    target.colors = ColumnsToColors(vertex);
}

/// Texture coordinates for each face (MeshLab's `texcoord` list). Equal pairs become one entry.
/// Triangles only.
void ReadFaceUvs(const PlyElement& face, Mesh& mesh) {
  const auto it = face.lists.find("texcoord");
  if (it == face.lists.end() || static_cast<Eigen::Index>(face.count) != mesh.faces.rows()) return;
  const PlyList& list = it->second;
  if (list.values.size() != face.count * 6) return;
  std::map<std::pair<double, double>, int> ids;
  std::vector<Eigen::Vector2d> uvs;
  mesh.uv_faces.resize(mesh.faces.rows(), 3);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const std::size_t at = static_cast<std::size_t>(f) * 6 + static_cast<std::size_t>(k) * 2;
      const auto [entry, is_new] =
          ids.emplace(std::pair(list.values[at], list.values[at + 1]), SizeOf(uvs));
      if (is_new) uvs.emplace_back(list.values[at], list.values[at + 1]);
      mesh.uv_faces(f, k) = entry->second;
    }
  mesh.uvs.resize(std::ssize(uvs), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i) mesh.uvs.row(i) = uvs[i];
}

Mesh ReadPlyMesh(const fs::path& path) {
  const PlyTable table = ReadPly(path);
  const PlyElement& vertex = VertexElement(table, path);
  Mesh mesh;
  mesh.points = ColumnsToPoints(vertex, {"x", "y", "z"});
  ReadVertexExtras(vertex, mesh);
  const auto face = table.find("face");
  if (face == table.end()) return mesh;
  for (const char* name : {"vertex_indices", "vertex_index"}) {
    const auto it = face->second.lists.find(name);
    if (it == face->second.lists.end()) continue;
    Fan fan(path, mesh.points.rows());
    const PlyList& list = it->second;
    for (std::size_t i = 0; i + 1 < list.offsets.size(); ++i)
      fan.Add(list.values.data() + list.offsets[i], list.offsets[i + 1] - list.offsets[i]);
    mesh.faces = fan.Take();
    ReadFaceUvs(face->second, mesh);
    break;
  }
  return mesh;
}

/// Reads a number at `at` like strtod, but most numbers much faster. Returns nullptr when there is
/// no number or it is not finite.
const char* SkipNumber(const char* at, const char* end) {
  while (at < end && (*at == ' ' || *at == '\t')) ++at;
  double value = 0;
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
    const std::size_t end = text[at] != '\\'                       ? at
                            : text.compare(at + 1, 2, "\r\n") == 0 ? at + 2
                                                                   : at + 1;
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

/// The OBJ library reads 'nan', 'inf' and words as 0, which would hide damage. So the text of the
/// positions is checked first.
void RequireNumbersInObj(const fs::path& path, const std::string& text) {
  int number = 0;
  for (std::size_t begin = 0, end = 0; begin < text.size(); begin = end + 1) {
    end = std::min(text.find('\n', begin), text.size());
    ++number;
    if (end - begin < 2 || text[begin] != 'v' ||
        (text[begin + 1] != ' ' && text[begin + 1] != '\t'))
      continue;
    const char* at = text.data() + begin + 1;
    for (int k = 0; k < 3; ++k) {
      at = SkipNumber(at, text.data() + end);
      if (!at)
        throw InputError(fmt::format(
            "{}:{}: '{}' is not a vertex with three finite numbers (NaN or infinity?); repair the "
            "file and export it again",
            path.string(), number, text.substr(begin, std::min<std::size_t>(60, end - begin))));
    }
  }
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
    if (uvs_.empty() || uv_corners_.size() != corners_.size()) return mesh;
    mesh.uvs = Eigen::Map<const UvsX2>(uvs_.data(), static_cast<Eigen::Index>(uvs_.size() / 2), 2);
    mesh.uv_faces = Fanned(uv_corners_, mesh.uvs.rows());
    return mesh;
  }

 private:
  static ObjCollector& Of(void* self) { return *static_cast<ObjCollector*>(self); }

  void Put(std::vector<double>& values, std::initializer_list<double> more) {
    values.insert(values.end(), more);
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
      // Texture coordinates are only used when all faces have them.
      if (corners[k].texcoord_index != 0)
        uv_corners_.push_back(FromZero(corners[k].texcoord_index, uvs_.size() / 2));
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

  const fs::path& path_;
  std::vector<double> points_, uvs_;       // 3 and 2 a vertex
  std::vector<int> corners_, uv_corners_;  // of all faces, concatenated
  std::vector<std::size_t> sizes_;         // corners of each face
};

Mesh ReadObjMesh(const fs::path& path) {
  std::string text = WithWholeLines(ReadFile(path));
  RequireNumbersInObj(path, text);
  std::istringstream in(std::move(text));
  ObjCollector collector(path);
  collector.Read(in);
  return collector.Take();
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

/// Reads OFF with CGAL's scanner. CGAL's own reader allocates memory for any number that the header
/// or a face claims. Here no number may exceed what the rest of the file can hold.
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
  if (start.find("OFF") != std::string::npos && start.find("OFF") < 5) return ReadOffMesh(path);
  if (start.rfind("SOLID", 0) == 0 || LooksLikeBinaryStl(path, head)) return ReadStlMesh(path);
  if (LooksLikeObj(head)) return ReadObjMesh(path);
  throw InputError(path.string() +
                   " is not a PLY, OBJ, OFF or STL mesh (judged by its first bytes)");
}

PointCloud ReadPointCloud(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("point cloud " + path.string() + " does not exist");
  if (!fs::is_regular_file(path))
    throw DiskError("point cloud " + path.string() + " is not a file");
  const PlyTable table = ReadPly(path);
  const PlyElement& vertex = VertexElement(table, path);
  PointCloud cloud;
  cloud.points = ColumnsToPoints(vertex, {"x", "y", "z"});
  ReadVertexExtras(vertex, cloud);
  if (vertex.Has("confidence")) {
    const auto& column = vertex.scalars.at("confidence");
    cloud.confidence =
        Eigen::Map<const Eigen::VectorXd>(column.data(), std::ssize(column)).cast<float>();
  }
  return cloud;
}

}  // namespace keypose
