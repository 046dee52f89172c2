// The writing halves of mesh_io.h and polygon_mesh.h.
#include <fmt/format.h>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <string_view>
#include <utility>

#include "core/io/meshes/mesh_io.h"
#include "core/io/meshes/ply_frames.h"
#include "core/io/meshes/polygon_mesh.h"
#include "core/io/text/files.h"
#include "core/surfaces/face_net.h"
#include "core/values/errors.h"

namespace keypose {
namespace fs = std::filesystem;

namespace {

template <class T>
void Put(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof(T));
}

template <class Source>
bool HasNormals(const Source& source) {
  return source.normals.rows() == source.points.rows();
}

/// Header lines of the vertex element, for meshes and clouds.
template <class Source>
void PutVertexHeader(std::string& out, const Source& source, bool normals) {
  out += fmt::format("element vertex {}\nproperty double x\nproperty double y\nproperty double z\n",
                     source.points.rows());
  if (normals) out += "property float nx\nproperty float ny\nproperty float nz\n";
  if (source.colors.rows() == source.points.rows())
    out += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
}

template <class Source>
void PutVertex(std::string& out, const Source& source, bool normals, Eigen::Index v) {
  for (int k = 0; k < 3; ++k) Put<double>(out, source.points(v, k));
  if (normals)
    for (int k = 0; k < 3; ++k) Put<float>(out, static_cast<float>(source.normals(v, k)));
  if (source.colors.rows() == source.points.rows())
    for (int k = 0; k < 3; ++k) Put<std::uint8_t>(out, source.colors(v, k));
}

constexpr const char* kPlyHead = "ply\nformat binary_little_endian 1.0\ncomment Keypose\n";

/// @tparam Uv  type of the texture coordinates, called `uv_type` in the file
template <class Uv = double>
std::string PlyBytes(const Mesh& mesh, bool normals, const char* uv_type = "double") {
  std::string out = kPlyHead;
  PutVertexHeader(out, mesh, normals);
  out +=
      fmt::format("element face {}\nproperty list uchar int vertex_indices\n", mesh.faces.rows());
  if (mesh.has_uvs()) out += fmt::format("property list uchar {} texcoord\n", uv_type);
  out += "end_header\n";
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v) PutVertex(out, mesh, normals, v);
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f) {
    Put<std::uint8_t>(out, 3);
    for (int k = 0; k < 3; ++k) Put<std::int32_t>(out, mesh.faces(f, k));
    if (!mesh.has_uvs()) continue;
    Put<std::uint8_t>(out, 6);
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 2; ++c) Put(out, static_cast<Uv>(mesh.uvs(mesh.uv_faces(f, k), c)));
  }
  return out;
}

std::string ObjText(const Mesh& mesh, const FaceNet& net, const std::string& material_library) {
  fmt::memory_buffer out;
  auto to = std::back_inserter(out);
  if (!material_library.empty()) fmt::format_to(to, "mtllib {}\nusemtl clay\n", material_library);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    fmt::format_to(to, "v {:.17g} {:.17g} {:.17g}\n", mesh.points(v, 0), mesh.points(v, 1),
                   mesh.points(v, 2));
  if (mesh.has_uvs())
    for (Eigen::Index t = 0; t < mesh.uvs.rows(); ++t)
      fmt::format_to(to, "vt {:.17g} {:.17g}\n", mesh.uvs(t, 0), mesh.uvs(t, 1));
  std::size_t corner = 0;
  for (const int size : net.sizes) {
    fmt::format_to(to, "f");
    for (const std::size_t end = corner + static_cast<std::size_t>(size); corner < end; ++corner) {
      if (net.uvs.empty())
        fmt::format_to(to, " {}", net.vertices[corner] + 1);
      else
        fmt::format_to(to, " {}/{}", net.vertices[corner] + 1, net.uvs[corner] + 1);
    }
    fmt::format_to(to, "\n");
  }
  return fmt::to_string(out);
}

}  // namespace

void RequireMeshName(const fs::path& path) {
  if (path.extension() != ".ply" && path.extension() != ".obj")
    throw UsageError("cannot write a mesh as " + PrintableName(path) + ": name it .ply or .obj");
}

namespace {

void WriteObj(const fs::path& path, const Mesh& mesh, const FaceNet& net,
              const std::string& material_texture) {
  fs::path library;
  if (!material_texture.empty() && mesh.has_uvs()) {
    library = path;
    library.replace_extension(".mtl");
    WriteFile(library, fmt::format("newmtl clay\nKa 1 1 1\nKd 1 1 1\nKs 0 0 0\nmap_Kd {}\n",
                                   material_texture));
  }
  WriteFile(path, ObjText(mesh, net, library.filename().string()));
}

}  // namespace

void WriteMesh(const fs::path& path, const Mesh& mesh, const std::string& material_texture) {
  RequireMeshName(path);
  if (path.extension() == ".ply") return WriteFile(path, PlyBytes(mesh, HasNormals(mesh)));
  WriteObj(path, mesh, NetOf(mesh, {}), material_texture);
}

void WritePolygonObj(const fs::path& path, const PolygonMesh& mesh,
                     const std::string& material_texture) {
  WriteObj(path, mesh.mesh, NetOf(mesh.mesh, mesh.polygons), material_texture);
}

namespace {

std::size_t EndOfHeader(const std::string& bytes) {
  constexpr std::string_view kEnd = "end_header\n";
  return bytes.find(kEnd) + kEnd.size();
}

/// The bytes of a vertex without a normal.
std::size_t VertexBytes(const Mesh& mesh) {
  return 3 * sizeof(double) + (mesh.colors.rows() == mesh.points.rows() ? 3 : 0);
}

/// Writes a file of which all is known but the positions, from `at` on.
void WriteFrame(const fs::path& path, const PointsX3& points, std::size_t at,
                std::size_t vertex_bytes, std::string* bytes) {
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    std::memcpy(bytes->data() + at + static_cast<std::size_t>(v) * vertex_bytes,
                points.data() + 3 * v, 3 * sizeof(double));
  WriteFile(path, *bytes);
}

}  // namespace

PlyFrames::PlyFrames(const Mesh& mesh)
    : bytes_(PlyBytes(mesh, false)),
      vertices_at_(EndOfHeader(bytes_)),
      vertex_bytes_(VertexBytes(mesh)) {}

void PlyFrames::Write(const fs::path& path, const PointsX3& points) {
  WriteFrame(path, points, vertices_at_, vertex_bytes_, &bytes_);
}

PlyFramesForOthers::PlyFramesForOthers(const Mesh& mesh)
    : bytes_(PlyBytes<float>(mesh, false, "float")),
      vertices_at_(EndOfHeader(bytes_)),
      vertex_bytes_(VertexBytes(mesh)) {}

void PlyFramesForOthers::Write(const fs::path& path, const PointsX3& points) {
  WriteFrame(path, points, vertices_at_, vertex_bytes_, &bytes_);
}

void WritePointCloud(const fs::path& path, const PointCloud& cloud) {
  const bool with_confidence = cloud.confidence.size() == cloud.points.rows();
  std::string out = kPlyHead;
  PutVertexHeader(out, cloud, HasNormals(cloud));
  if (with_confidence) out += "property float confidence\n";
  out += "end_header\n";
  for (Eigen::Index p = 0; p < cloud.points.rows(); ++p) {
    PutVertex(out, cloud, HasNormals(cloud), p);
    if (with_confidence) Put<float>(out, cloud.confidence(p));
  }
  WriteFile(path, out);
}

}  // namespace keypose
