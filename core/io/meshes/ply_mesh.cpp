#include "core/io/meshes/ply_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/io/meshes/face_colors.h"
#include "core/io/meshes/ply_io.h"
#include "core/io/meshes/polygon_cut.h"
#include "core/io/meshes/polygon_fan.h"
#include "core/values/errors.h"
#include "core/values/size_of.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

using Names = std::array<const char*, 3>;

bool HasAll(const PlyElement& element, const Names& names) {
  return element.Has(names[0]) && element.Has(names[1]) && element.Has(names[2]);
}

PointsX3 ColumnsToPoints(const PlyElement& element, const Names& names) {
  PointsX3 points(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at(names[k]);
    for (std::size_t i = 0; i < column.size(); ++i)
      points(static_cast<Eigen::Index>(i), k) = column[i];
  }
  return points;
}

/// What white is in colours of this type. PLY does not say: by custom bytes go to 255 and wider
/// integers to what they can hold, but many programs write levels of 255 as int, float or double.
double WhiteOf(PlyType type, double most) {
  constexpr double kWhiteRounding = 1e-3;
  const bool real = type == PlyType::kFloat32 || type == PlyType::kFloat64;
  if (real && most <= 1 + kWhiteRounding) return 1;
  if (most <= 255) return 255;
  return most <= 65535 ? 65535 : most;
}

/// The names by which programs call colours, the most usual first.
constexpr std::array<Names, 4> kColors = {{{"red", "green", "blue"},
                                           {"diffuse_red", "diffuse_green", "diffuse_blue"},
                                           {"r", "g", "b"},
                                           {"ambient_red", "ambient_green", "ambient_blue"}}};

/// The bits of a packed colour, 0xRRGGBB, with alpha above. In ASCII a float may be the number or
/// have its bits.
std::uint32_t PackedBits(double value, PlyType type) {
  const bool real = type == PlyType::kFloat32 || type == PlyType::kFloat64;
  constexpr double kMost = 16777215;  // white
  if (real && !(value >= 1 && value <= kMost && value == std::floor(value)))
    return std::bit_cast<std::uint32_t>(static_cast<float>(value));
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(value));
}

/// Colours that are one number each; empty: the element has none that can be read.
ColorsX3 PackedColorsOf(const PlyElement& element) {
  for (const char* name : {"rgb", "rgba"}) {
    if (!element.Has(name)) continue;
    const PlyType type = element.types.at(name);
    const std::vector<double>& column = element.scalars.at(name);
    const bool narrow = type < PlyType::kInt32;
    if (narrow || std::any_of(column.begin(), column.end(), [](double v) { return std::isnan(v); }))
      continue;
    ColorsX3 colors(static_cast<Eigen::Index>(element.count), 3);
    for (std::size_t i = 0; i < column.size(); ++i) {
      const std::uint32_t bits = PackedBits(column[i], type);
      for (int k = 0; k < 3; ++k)
        colors(static_cast<Eigen::Index>(i), k) = static_cast<std::uint8_t>(bits >> (16 - 8 * k));
    }
    return colors;
  }
  return {};
}

/// Empty: the element has none.
ColorsX3 ColorsOf(const PlyElement& element) {
  const auto names = std::find_if(kColors.begin(), kColors.end(),
                                  [&](const Names& n) { return HasAll(element, n); });
  if (names == kColors.end()) return PackedColorsOf(element);
  double white = 0;
  for (const char* name : *names) {
    double most = 0;
    for (const double value : element.scalars.at(name))
      if (std::isfinite(value)) most = std::max(most, value);
    white = std::max(white, WhiteOf(element.types.at(name), most));
  }
  ColorsX3 colors(static_cast<Eigen::Index>(element.count), 3);
  for (int k = 0; k < 3; ++k) {
    const auto& column = element.scalars.at((*names)[k]);
    // Bytes that are called signed by mistake.
    const double wrapped = element.types.at((*names)[k]) == PlyType::kInt8 ? 256 : 0;
    for (std::size_t i = 0; i < column.size(); ++i) {
      const double value = column[i] < 0 ? column[i] + wrapped : column[i];
      const double level = std::isfinite(value) ? 255 * value / white : 0;
      colors(static_cast<Eigen::Index>(i), k) =
          static_cast<std::uint8_t>(std::lround(std::clamp(level, 0.0, 255.0)));
    }
  }
  return colors;
}

[[noreturn]] void Fail(const fs::path& path, const std::string& why) {
  throw InputError(fmt::format("{}: the PLY file {}", path.string(), why));
}

const PlyElement* ElementOf(const PlyTable& table, const std::string& name) {
  const auto it = table.find(name);
  return it == table.end() ? nullptr : &it->second;
}

const PlyElement& VertexElement(const PlyTable& table, const fs::path& path) {
  const PlyElement* vertex = ElementOf(table, "vertex");
  if (!vertex || !HasAll(*vertex, {"x", "y", "z"})) Fail(path, "has no vertices with x, y and z");
  return *vertex;
}

template <class Target>
void ReadVertexExtras(const PlyElement& vertex, Target& target) {
  if (HasAll(vertex, {"nx", "ny", "nz"}))
    target.normals = ColumnsToPoints(vertex, {"nx", "ny", "nz"});
  target.colors = ColorsOf(vertex);
}

const PlyList* ListOf(const PlyElement& element, std::initializer_list<const char*> names) {
  for (const char* name : names)
    if (const auto it = element.lists.find(name); it != element.lists.end()) return &it->second;
  return nullptr;
}

/// The faces' corners, which face each triangle is of, and those that are no fans.
struct PlyFaces {
  const PlyList* corners = nullptr;
  std::vector<int> of_triangle;
  std::optional<PolygonCuts> cuts;
};

/// @pre the corners are vertices
std::optional<PolygonCuts> CutsOf(const PlyList& list, const PointsX3& points) {
  std::vector<std::size_t> sizes;
  for (std::size_t i = 0; i + 1 < list.offsets.size(); ++i)
    sizes.push_back(list.offsets[i + 1] - list.offsets[i]);
  if (std::all_of(sizes.begin(), sizes.end(), [](std::size_t size) { return size < 4; })) return {};
  return PolygonCuts(points, {list.values.begin(), list.values.end()}, sizes);
}

FacesX3 FacesOf(const PlyList& list, const fs::path& path, const PointsX3& points,
                PlyFaces* polygons) {
  Fan fan(path, points.rows());
  for (std::size_t i = 0; i + 1 < list.offsets.size(); ++i) {
    const std::size_t count = list.offsets[i + 1] - list.offsets[i];
    fan.Add(list.values.data() + list.offsets[i], count);
    for (std::size_t k = 2; k < count; ++k) polygons->of_triangle.push_back(static_cast<int>(i));
  }
  FacesX3 faces = fan.Take();
  polygons->cuts = CutsOf(list, points);
  if (polygons->cuts) polygons->cuts->Apply({list.values.begin(), list.values.end()}, &faces);
  return faces;
}

/// Texture coordinates of the faces' corners (MeshLab's list `texcoord`). Equal pairs become one
/// entry. A face may have none: its corners get (0, 0).
/// @throws InputError  a face has another number of them than of corners; not finite
void ReadCornerUvs(const PlyElement& face, const PlyFaces& polygons, const fs::path& path,
                   Mesh& mesh) {
  const PlyList* list = ListOf(face, {"texcoord", "texcoords"});
  if (!list || list->values.empty()) return;
  const std::vector<std::size_t>& offsets = polygons.corners->offsets;
  std::map<std::pair<double, double>, int> ids;
  std::vector<Eigen::Vector2d> uvs;
  const auto id_of = [&](double u, double v) {
    const auto [entry, is_new] = ids.emplace(std::pair(u, v), SizeOf(uvs));
    if (is_new) uvs.emplace_back(u, v);
    return entry->second;
  };
  std::vector<int> uv_of_corner(polygons.corners->values.size());
  for (std::size_t f = 0; f + 1 < offsets.size(); ++f) {
    const std::size_t corners = offsets[f + 1] - offsets[f], from = list->offsets[f],
                      given = list->offsets[f + 1] - from;
    if (given != 0 && given != 2 * corners)
      Fail(path,
           fmt::format("has {} numbers in the list texcoord of face {}, which has {} corners; "
                       "two a corner were expected",
                       given, f, corners));
    for (std::size_t c = 0; c < corners; ++c) {
      const double u = given == 0 ? 0 : list->values[from + 2 * c],
                   v = given == 0 ? 0 : list->values[from + 2 * c + 1];
      if (!std::isfinite(u) || !std::isfinite(v))
        Fail(path, fmt::format("has texture coordinates that are not finite, in face {}", f));
      uv_of_corner[offsets[f] + c] = id_of(u, v);
    }
  }
  Fan fan(path, std::ssize(uvs));
  for (std::size_t i = 0; i + 1 < offsets.size(); ++i)
    fan.Add(uv_of_corner.data() + offsets[i], offsets[i + 1] - offsets[i]);
  mesh.uv_faces = fan.Take();
  if (polygons.cuts) polygons.cuts->Apply(uv_of_corner, &mesh.uv_faces);
  mesh.uvs.resize(std::ssize(uvs), 2);
  for (std::size_t i = 0; i < uvs.size(); ++i)
    mesh.uvs.row(static_cast<Eigen::Index>(i)) = uvs[i].transpose();
}

/// Texture coordinates of the vertices, which are doubled at seams then: Blender writes `s t`,
/// MeshLab `texture_u texture_v`.
void ReadVertexUvs(const PlyElement& vertex, const fs::path& path, Mesh& mesh) {
  constexpr std::array<std::pair<const char*, const char*>, 6> kNames = {
      {{"s", "t"},
       {"u", "v"},
       {"texture_u", "texture_v"},
       {"texture_s", "texture_t"},
       {"s0", "t0"},
       {"u0", "v0"}}};
  for (const auto& [u, v] : kNames) {
    if (!vertex.Has(u) || !vertex.Has(v)) continue;
    mesh.uvs.resize(mesh.points.rows(), 2);
    for (Eigen::Index i = 0; i < mesh.uvs.rows(); ++i)
      mesh.uvs.row(i) << vertex.scalars.at(u)[i], vertex.scalars.at(v)[i];
    if (!mesh.uvs.allFinite()) Fail(path, "has texture coordinates that are not finite");
    mesh.uv_faces = mesh.faces;
    return;
  }
}

/// Colours of the faces, where the vertices have none: each vertex gets the mean of its faces'.
/// @return whether any were blended
bool ReadFaceColors(const PlyElement& face, const PlyFaces& polygons, Mesh& mesh) {
  const ColorsX3 colors = ColorsOf(face);
  if (colors.rows() == 0 || mesh.colors.rows() > 0) return false;
  Eigen::MatrixX3d levels(mesh.faces.rows(), 3);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    levels.row(f) = colors.row(polygons.of_triangle[static_cast<std::size_t>(f)]).cast<double>();
  return TakeFaceColors(levels, &mesh);
}

/// What looks like colour and is none that is read, where a mesh has no other.
void NoteOtherColors(const PlyElement& element, const char* whose,
                     std::vector<std::string>* notes) {
  for (const char* name : {"intensity", "scalar_intensity", "gray", "grey", "luminance",
                           "reflectance", "rgb", "rgba", "color", "colour", "colors"})
    if (element.Has(name) || element.lists.contains(name))
      notes->push_back(
          fmt::format("it has no colours that are read; '{}' of its {} is left out", name, whose));
}

/// Strips of triangles, each ended by -1: every second triangle runs the other way round.
FacesX3 StripFaces(const PlyList& list, const fs::path& path, Eigen::Index vertices) {
  Fan fan(path, vertices);
  for (std::size_t i = 0; i + 1 < list.offsets.size(); ++i) {
    std::size_t begin = list.offsets[i];
    for (std::size_t at = begin; at < list.offsets[i + 1]; ++at) {
      if (list.values[at] == -1) begin = at + 1;
      if (at < begin + 2) continue;
      std::array<double, 3> corners = {list.values[at - 2], list.values[at - 1], list.values[at]};
      if ((at - begin) % 2 == 1) std::swap(corners[0], corners[1]);
      const bool thin = corners[0] == corners[1] || corners[1] == corners[2] ||
                        corners[0] == corners[2];  // joins two strips
      if (!thin) fan.Add(corners.data(), 3);
    }
  }
  return fan.Take();
}

/// The page of each triangle; empty where the file has one texture.
std::vector<int> PagesOf(const PlyElement& face, const PlyFaces& polygons, const fs::path& path) {
  if (!face.Has("texnumber")) return {};
  const std::vector<double>& numbers = face.scalars.at("texnumber");
  std::vector<int> pages;
  for (const int polygon : polygons.of_triangle) {
    const double number = numbers[static_cast<std::size_t>(polygon)];
    if (!(number >= -1 && number < 1e6)) Fail(path, "has a texnumber that is no texture's");
    pages.push_back(static_cast<int>(number));
  }
  return pages;
}

/// Kinds of PLY that hold no mesh of polygons, by what they are.
void RequireMesh(const PlyTable& table, const PlyElement& vertex, const fs::path& path) {
  if (vertex.Has("f_dc_0") && vertex.Has("scale_0") && vertex.Has("rot_0"))
    Fail(path, "holds Gaussian splats and no mesh; export a mesh from the program that made it");
  if (ElementOf(table, "range_grid"))
    Fail(path, "holds a range grid (element range_grid) and no faces; make it a mesh in MeshLab");
  if (ElementOf(table, "multi_texture_face"))
    Fail(path,
         "holds several layouts (element multi_texture_face), which are not read; export the mesh "
         "as OBJ");
}

}  // namespace

PlyPages ReadPlyPages(const fs::path& path) {
  const PlyTable table = ReadPly(path);
  const PlyElement& vertex = VertexElement(table, path);
  RequireMesh(table, vertex, path);
  PlyPages pages;
  Mesh& mesh = pages.mesh;
  mesh.points = ColumnsToPoints(vertex, {"x", "y", "z"});
  ReadVertexExtras(vertex, mesh);
  const PlyElement* face = ElementOf(table, "face");
  PlyFaces polygons;
  if (face) polygons.corners = ListOf(*face, {"vertex_indices", "vertex_index"});
  if (face && face->count > 0 && !polygons.corners)
    Fail(path, "has faces without a list vertex_indices or vertex_index");
  if (polygons.corners) {
    mesh.faces = FacesOf(*polygons.corners, path, mesh.points, &polygons);
    ReadCornerUvs(*face, polygons, path, mesh);
    if (ReadFaceColors(*face, polygons, mesh)) pages.notes.push_back(kColorsBlend);
    pages.page_of_face = PagesOf(*face, polygons, path);
  }
  const PlyElement* strips = ElementOf(table, "tristrips");
  const PlyList* strip_corners =
      strips ? ListOf(*strips, {"vertex_indices", "vertex_index"}) : nullptr;
  if (strips && strips->count > 0 && !strip_corners)
    Fail(path, "has tristrips without a list vertex_indices");
  if (strip_corners && strips->count > 0) {
    if (mesh.faces.rows() > 0) Fail(path, "has both faces and tristrips; keep one of them");
    mesh.faces = StripFaces(*strip_corners, path, mesh.points.rows());
  }
  if (mesh.faces.rows() > 0 && !mesh.has_uvs()) ReadVertexUvs(vertex, path, mesh);
  if (mesh.colors.rows() == 0) {
    NoteOtherColors(vertex, "vertices", &pages.notes);
    if (face) NoteOtherColors(*face, "faces", &pages.notes);
  }
  return pages;
}

Mesh ReadPlyMesh(const fs::path& path) { return ReadPlyPages(path).mesh; }

PointCloud ReadPlyCloud(const fs::path& path) {
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
