// What a mesh was when a person picked something on it, so that the pick can be found again on a
// mesh that was made anew.
#pragma once

#include <optional>
#include <string>

#include "core/kd_tree.h"
#include "core/mesh.h"

namespace keypose {

/// SHA-256 of the positions, in single precision, and the faces: the same for a PLY, and for an OBJ
/// with texture coordinates, of one mesh.
std::string GeometryHash(const Mesh& mesh);
/// SHA-256 of the number of vertices and the faces: equal where vertex and face numbers mean the
/// same, as in a template and its poses.
std::string NumberingHash(const Mesh& mesh);

/// How a mesh looks at a point of its surface.
struct SurfacePlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  /// unit; mean over the surface around that faces the same way
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  /// mean over the same, 0 to 255; none where the mesh has no colours
  std::optional<Eigen::Vector3d> color;
};

/// Reads places off a mesh, which must outlive it. `Around` is 1.5 % of the bounding diagonal.
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

/// Which mesh it was, and a sample of its shape: enough to align it with another mesh of the same
/// thing.
struct MeshBinding {
  int vertex_count = 0, face_count = 0;
  std::string geometry, numbering;  ///< the hashes above; empty in files that older programs wrote
  double diagonal = 0;
  PointsX3 points, normals;  ///< the sample, even over the area; S x 3
  PointsX3 colors;           ///< S x 3, 0 to 255, or empty

  bool known() const { return !geometry.empty(); }
};

/// Deterministic.
MeshBinding BindTo(const Mesh& mesh);

}  // namespace keypose
