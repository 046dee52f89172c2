#include "core/surfaces/mesh_binding.h"

#include <Eigen/Geometry>
#include <string_view>

#include "core/numbers/sha256.h"
#include "core/surfaces/geometry.h"
#include "core/surfaces/mesh_checks.h"
#include "core/values/errors.h"

namespace keypose {

namespace {

constexpr int kSamples = 400;
constexpr double kAround = 0.015;  // of the diagonal

std::string_view BytesOf(const auto& matrix) {
  return {reinterpret_cast<const char*>(matrix.data()),
          static_cast<std::size_t>(matrix.size()) * sizeof(*matrix.data())};
}

void AddFaces(Sha256& hash, const Mesh& mesh) {
  hash.Add(std::to_string(mesh.vertex_count()) + " vertices ");
  hash.Add(BytesOf(mesh.faces));
}

Eigen::Vector3d BarycentricOf(const Mesh& mesh, int face, const Eigen::Vector3d& point) {
  const Eigen::Vector3d a = mesh.points.row(mesh.faces(face, 0));
  const Eigen::Vector3d ab = mesh.points.row(mesh.faces(face, 1)).transpose() - a;
  const Eigen::Vector3d ac = mesh.points.row(mesh.faces(face, 2)).transpose() - a;
  const Eigen::Vector3d normal = ab.cross(ac);
  const double area = normal.squaredNorm();
  if (area <= 0) return Eigen::Vector3d::Unit(0);
  const double v = (point - a).cross(ac).dot(normal) / area,
               w = ab.cross(point - a).dot(normal) / area;
  return {1 - v - w, v, w};
}

}  // namespace

std::string GeometryHash(const Mesh& mesh) {
  // Single precision, because an OBJ loses the last bits of a double. Adding zero turns -0 into 0.
  const Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor> points =
      mesh.points.cast<float>().array() + 0.0f;
  Sha256 hash;
  AddFaces(hash, mesh);
  hash.Add(BytesOf(points));
  return hash.Hex();
}

std::string NumberingHash(const Mesh& mesh) {
  Sha256 hash;
  AddFaces(hash, mesh);
  return hash.Hex();
}

SurfacePlaces::SurfacePlaces(const Mesh& mesh)
    : mesh_(mesh),
      normals_(VertexNormals(mesh.points, mesh.faces)),
      vertices_(mesh.points),
      around_(kAround * BoundingDiagonal(mesh.points)) {}

SurfacePlace SurfacePlaces::At(int face, const Eigen::Vector3d& barycentric) const {
  const bool colored = mesh_.colors.rows() == mesh_.points.rows();
  SurfacePlace place;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero(), color = Eigen::Vector3d::Zero();
  for (int k = 0; k < 3; ++k) {
    const int v = mesh_.faces(face, k);
    place.position += barycentric[k] * mesh_.points.row(v).transpose();
    normal += barycentric[k] * normals_.row(v).transpose();
    if (colored) color += barycentric[k] * mesh_.colors.row(v).cast<double>().transpose();
  }
  // The other side of a thin part is near, but does not belong to the surrounding surface.
  const Eigen::Vector3d here = normal;
  double weight = 1;
  for (const KdTree::Neighbor& near : vertices_.Within(place.position, around_)) {
    const Eigen::Vector3d other = normals_.row(near.index);
    if (other.dot(here) <= 0) continue;
    normal += other;
    if (colored) color += mesh_.colors.row(near.index).cast<double>().transpose();
    weight += 1;
  }
  if (normal.norm() > 0) place.normal = normal.normalized();
  if (colored) place.color = color / weight;
  return place;
}

MeshBinding BindTo(const Mesh& mesh) {
  RequireUsable(mesh, "the mesh to bind to");
  MeshBinding binding;
  binding.vertex_count = mesh.vertex_count();
  binding.face_count = mesh.face_count();
  binding.geometry = GeometryHash(mesh);
  binding.numbering = NumberingHash(mesh);
  binding.diagonal = BoundingDiagonal(mesh.points);
  const SurfaceSamples samples = SampleSurface(mesh.points, mesh.faces, kSamples, 1);
  const SurfacePlaces places(mesh);
  const Eigen::Index count = samples.points.rows();
  binding.points = samples.points;
  binding.normals.resize(count, 3);
  if (mesh.colors.rows() == mesh.points.rows()) binding.colors.resize(count, 3);
  for (Eigen::Index i = 0; i < count; ++i) {
    const int face = samples.faces[i];
    const SurfacePlace place = places.At(face, BarycentricOf(mesh, face, samples.points.row(i)));
    binding.normals.row(i) = place.normal.transpose();
    if (place.color) binding.colors.row(i) = place.color->transpose();
  }
  return binding;
}

}  // namespace keypose
