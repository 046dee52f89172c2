// A description of the mesh on which a person picked something, so that the pick can be found again
// when the mesh is rebuilt.
#pragma once

#include <optional>
#include <string>

#include "core/numbers/kd_tree.h"
#include "core/values/mesh.h"

namespace keypose {

/// SHA-256 of the positions, in single precision, and of the faces. The PLY file of a mesh and its
/// OBJ file with texture coordinates give the same hash.
std::string GeometryHash(const Mesh& mesh);
/// SHA-256 of the number of vertices and of the faces. It is equal for meshes whose vertex and face
/// numbers correspond, such as a template and its registered poses.
std::string NumberingHash(const Mesh& mesh);

/// Position, normal and colour of a mesh at a point of its surface.
struct SurfacePlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// unit; mean over the surrounding surface that faces the same way
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  /// mean over the same surface, 0 to 255; none when the mesh has no colours
  std::optional<Eigen::Vector3d> color;
};

/// Finds the places of points on a mesh, which must outlive this object. The surrounding surface
/// reaches 1.5 % of the bounding diagonal.
class SurfacePlaces {
 public:
  /// @throws InputError  no vertices or faces
  explicit SurfacePlaces(const Mesh& mesh);
  SurfacePlace At(int face, const Eigen::Vector3d& barycentric) const;
  const PointsX3& vertex_normals() const { return normals_; }
  const KdTree& vertices() const { return vertices_; }

 private:
  const Mesh& mesh_;
  PointsX3 normals_;
  KdTree vertices_;
  double around_;
};

/// Identifies a mesh, and holds samples of its shape: enough to align it with another mesh of the
/// same object.
struct MeshBinding {
  int vertex_count = 0, face_count = 0;
  std::string geometry, numbering;  ///< the hashes above; empty in files of older versions
  double diagonal = 0;
  PointsX3 points, normals;  ///< samples, uniform by area; S x 3
  PointsX3 colors;           ///< S x 3, 0 to 255, or empty

  bool known() const { return !geometry.empty(); }
};

/// Describes a mesh. Deterministic.
MeshBinding BindTo(const Mesh& mesh);

}  // namespace keypose
