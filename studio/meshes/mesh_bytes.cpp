#include "studio/meshes/mesh_bytes.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>

#include "core/surfaces/geometry.h"
#include "core/surfaces/ray_scene.h"
#include "core/surfaces/surface_distance.h"

namespace keypose::studio {
namespace {

static_assert(std::endian::native == std::endian::little, "the page reads little-endian numbers");

constexpr std::uint32_t kUvs = 1, kColors = 2;

class Bytes {
 public:
  explicit Bytes(std::size_t size) { text_.reserve(size); }
  template <class T>
  void Add(T value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    text_.append(bytes, sizeof value);
  }
  void AddHead(std::size_t vertices, std::size_t faces, std::uint32_t flags) {
    text_ += "KPM1";
    Add(static_cast<std::uint32_t>(vertices));
    Add(static_cast<std::uint32_t>(faces));
    Add(flags);
  }
  std::string Take() { return std::move(text_); }

 private:
  std::string text_;
};

void AddColor(Bytes& bytes, const ColorsX3& colors, Eigen::Index row) {
  for (int k = 0; k < 3; ++k) bytes.Add(colors(row, k));
  bytes.Add(std::uint8_t{0});
}

}  // namespace

std::string MeshBytes(const Mesh& mesh) {
  const bool uvs = mesh.has_uvs(), colors = mesh.colors.rows() == mesh.points.rows();
  Bytes bytes(16 + 16 * static_cast<std::size_t>(mesh.vertex_count()) +
              36 * static_cast<std::size_t>(mesh.face_count()));
  bytes.AddHead(static_cast<std::size_t>(mesh.vertex_count()),
                static_cast<std::size_t>(mesh.face_count()),
                (uvs ? kUvs : 0) | (colors ? kColors : 0));
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    for (int k = 0; k < 3; ++k) bytes.Add(static_cast<float>(mesh.points(v, k)));
  for (Eigen::Index f = 0; f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k) bytes.Add(static_cast<std::uint32_t>(mesh.faces(f, k)));
  for (Eigen::Index f = 0; uvs && f < mesh.faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (int c = 0; c < 2; ++c) bytes.Add(static_cast<float>(mesh.uvs(mesh.uv_faces(f, k), c)));
  for (Eigen::Index v = 0; colors && v < mesh.points.rows(); ++v) AddColor(bytes, mesh.colors, v);
  return bytes.Take();
}

std::string CloudBytes(const PointCloud& cloud, int most) {
  const Eigen::Index all = cloud.points.rows(), shown = std::min<Eigen::Index>(all, most);
  const bool colors = cloud.colors.rows() == all && all > 0;
  Bytes bytes(16 + 16 * static_cast<std::size_t>(shown));
  bytes.AddHead(static_cast<std::size_t>(shown), 0, colors ? kColors : 0);
  for (Eigen::Index i = 0; i < shown; ++i)
    for (int k = 0; k < 3; ++k) bytes.Add(static_cast<float>(cloud.points(i * all / shown, k)));
  for (Eigen::Index i = 0; colors && i < shown; ++i) AddColor(bytes, cloud.colors, i * all / shown);
  return bytes.Take();
}

std::string FitBytes(const Mesh& mesh, const Mesh& scan) {
  const Eigen::VectorXd distances =
      DistancesTo(RayScene(scan.points, scan.faces), mesh.points) / BoundingDiagonal(scan.points);
  Bytes bytes(4 * static_cast<std::size_t>(distances.size()));
  for (const double distance : distances) bytes.Add(static_cast<float>(distance));
  return bytes.Take();
}

}  // namespace keypose::studio
