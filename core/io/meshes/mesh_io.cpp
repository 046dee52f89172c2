#include "core/io/meshes/mesh_io.h"

#include <CGAL/IO/OFF/File_scanner_OFF.h>
#include <CGAL/IO/STL.h>
#include <CGAL/Simple_cartesian.h>

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string_view>
#include <utility>

#include "core/io/meshes/glb_mesh.h"
#include "core/io/meshes/gltf_file.h"
#include "core/io/meshes/obj_file.h"
#include "core/io/meshes/ply_mesh.h"
#include "core/io/meshes/polygon_cut.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/io/text/files.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;
using Point = CGAL::Simple_cartesian<double>::Point_3;

namespace {

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
    std::vector<std::size_t> corners, sizes;
    std::vector<int> all;
    for (std::size_t f = 0; f < scanner_.size_of_facets(); ++f) {
      ReadFace(f, corners);
      fan.Add(corners.data(), corners.size());
      all.insert(all.end(), corners.begin(), corners.end());
      sizes.push_back(corners.size());
    }
    mesh.faces = fan.Take();
    PolygonCuts(mesh.points, all, sizes).Apply(all, &mesh.faces);
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
      {"Kaydara FBX", "an FBX file"},
      {"; FBX", "an FBX file"},
      {"#usda", "a USD file"},
      {"PXR-USDC", "a USD file"},
      {"BLENDER", "a Blender file"},
      {"Ogawa", "an Alembic file"},
      {"DRACO", "a Draco file (.drc)"},
      {"VRML", "a VRML file"},
      {"#VRML", "a VRML file"},
      {"#X3D", "an X3D file"},
      {"\x1f\x8b", "a file packed by gzip"},
      {"7z\xbc\xaf", "a file packed by 7-Zip"},
      {"Rar!", "a file packed by RAR"},
      {"<?xml", "an XML file"}};
  if (head.starts_with("<?xml") && head.find("<COLLADA") != head.npos) return "a Collada file";
  if (head.starts_with("<?xml") && head.find("<X3D") != head.npos) return "an X3D file";
  // Chunks: the whole file, and its version or its scene in it.
  using namespace std::string_view_literals;
  if (head.starts_with("MM") && head.size() >= 8 &&
      (head.substr(6, 2) == "\x02\0"sv || head.substr(6, 2) == "=="))
    return "a 3DS file";
  for (const auto& [start, kind] : kStarts)
    if (head.starts_with(start)) return kind;
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

MeshKind MeshKindOf(const fs::path& path) {
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
  const std::string kind = OtherMeshKind(head);
  std::size_t word = next_word(0);
  while (word < head.size() && head[word] == '#')
    word = next_word(std::min(head.find('\n', word), head.size()));
  std::string start = head.substr(word, 8);
  std::transform(start.begin(), start.end(), start.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  if (start.rfind("PLY", 0) == 0) return MeshKind::kPly;
  if (LooksLikeOff(start)) return MeshKind::kOff;
  if (LooksLikeBinaryStl(path, head)) return MeshKind::kStl;
  if (LooksLikeGltf(head)) return MeshKind::kGltf;
  if (head.starts_with("PK\x03\x04")) return MeshKind::kZip;
  if (start.rfind("SOLID", 0) == 0) return MeshKind::kStl;
  if (!kind.empty())
    throw InputError(path.string() + " is " + kind +
                     "; meshes are read from PLY, OBJ, OFF, STL and glTF: open it in Blender and "
                     "export it as OBJ (Wavefront)");
  if (LooksLikeObj(head)) return MeshKind::kObj;
  throw InputError(path.string() +
                   " is not a PLY, OBJ, OFF, STL or glTF mesh (judged by its first bytes)");
}

namespace {

/// The surface of a glTF. Its texture coordinates are kept where they are those of one texture.
Mesh ReadGltfMesh(const fs::path& path) {
  PagedMesh paged = ReadGlb(path).paged;
  if (paged.pages.size() > 1 || !paged.corner_colors.empty()) {
    paged.mesh.uvs.resize(0, 2);
    paged.mesh.uv_faces.resize(0, 3);
  }
  return std::move(paged.mesh);
}

}  // namespace

Mesh ReadMesh(const fs::path& path) {
  switch (MeshKindOf(path)) {
    case MeshKind::kPly:
      return ReadPlyMesh(path);
    case MeshKind::kObj:
      return ReadObj(path).mesh;
    case MeshKind::kOff:
      return ReadOffMesh(path);
    case MeshKind::kStl:
      return ReadStlMesh(path);
    case MeshKind::kGltf:
      return ReadGltfMesh(path);
    case MeshKind::kZip:
      throw InputError(path.string() +
                       " is a ZIP file (as .usdz and .3mf are): unpack it, or begin a project with "
                       "it by keypose init");
  }
  return {};
}

PointCloud ReadPointCloud(const fs::path& path) {
  if (!fs::exists(path)) throw DiskError("point cloud " + path.string() + " does not exist");
  if (!fs::is_regular_file(path))
    throw DiskError("point cloud " + path.string() + " is not a file");
  return ReadPlyCloud(path);
}

}  // namespace keypose
