#include "core/surfaces/mesh_checks.h"

#include <cmath>

#include "core/surfaces/geometry.h"
#include "core/values/coordinate_limit.h"
#include "core/values/errors.h"

namespace keypose {

void RequireUsable(const Mesh& mesh, const std::string& what) {
  if (mesh.vertex_count() == 0)
    throw InputError(what + ": the mesh has no vertices; check that the file is the one you meant");
  if (mesh.face_count() == 0)
    throw InputError(what +
                     ": the mesh has no faces; a point cloud must go through 'keypose mesh' first");
  RequireFinite(mesh.points, what);
  for (Eigen::Index v = 0; v < mesh.points.rows(); ++v)
    if (mesh.points.row(v).cwiseAbs().maxCoeff() > kMostCoordinate)
      throw InputError(what + ": vertex " + std::to_string(v) +
                       " lies more than 1e12 from the origin, where squares overflow in single "
                       "precision; remove that vertex and "
                       "its faces, or move the mesh to the origin");
  RequireIndices(mesh.points.rows(), mesh.faces, what);
}

void RequireFinite(const PointsX3& points, const std::string& what) {
  for (Eigen::Index v = 0; v < points.rows(); ++v)
    if (!points.row(v).allFinite())
      throw InputError(what + ": vertex " + std::to_string(v) +
                       " is not finite (NaN or infinity); remove that vertex and its faces, or run "
                       "the step that wrote the file again");
}

void RequireIndices(Eigen::Index vertex_count, const FacesX3& faces, const std::string& what) {
  for (Eigen::Index f = 0; f < faces.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      if (faces(f, k) < 0 || faces(f, k) >= vertex_count)
        throw InputError(what + ": face " + std::to_string(f) + " names vertex " +
                         std::to_string(faces(f, k)) + ", but there are " +
                         std::to_string(vertex_count) + "; the file is damaged");
}

void RequireVertex(Eigen::Index vertex, Eigen::Index vertex_count, const std::string& what,
                   const std::string& owner, const std::string& remedy) {
  if (vertex >= 0 && vertex < vertex_count) return;
  throw InputError(what + " names vertex " + std::to_string(vertex) + ", but " + owner + " " +
                   std::to_string(vertex_count) + " vertices" + remedy);
}

void RequireOnePerVertex(Eigen::Index count, Eigen::Index vertex_count, const std::string& what,
                         const std::string& unit, const std::string& owner,
                         const std::string& remedy) {
  if (count == vertex_count) return;
  throw InputError(what + " " + std::to_string(count) + " " + unit + ", but " + owner + " has " +
                   std::to_string(vertex_count) + " vertices" + remedy);
}

void RequireArea(const Mesh& mesh, const std::string& what) {
  if (SurfaceArea(mesh.points, mesh.faces) > 0) return;
  throw InputError(what +
                   ": the mesh has no area: the corners of each face lie on a line, as those of "
                   "face 0 do; is it flattened?");
}

void RequireExtent(const Mesh& mesh, const std::string& what) {
  if (BoundingDiagonal(mesh.points) > 0) return;
  throw InputError(what + ": all vertices coincide; pass a mesh with some extent");
}

void RequireNotNegative(double number, const std::string& what) {
  if (number >= 0 && std::isfinite(number)) return;
  throw InputError(what + " is negative or not finite");
}

void RequireUsable(const std::vector<LandmarkGoal>& landmarks, Eigen::Index source_vertices,
                   const std::string& what) {
  for (const LandmarkGoal& landmark : landmarks) {
    const std::string place = what + ": landmark '" + landmark.name + "'";
    for (const int v : landmark.source.vertices)
      if (v < 0 || v >= source_vertices)
        throw InputError(place + " is on vertex " + std::to_string(v) + ", but the source has " +
                         std::to_string(source_vertices) +
                         " vertices; pick it again on this source");
    if (!landmark.target.allFinite() || !landmark.source.weights.allFinite())
      throw InputError(place + " is not finite; pick it again");
  }
}

void RequireStiffness(const Eigen::VectorXd& stiffness, Eigen::Index source_vertices,
                      const std::string& what) {
  if (stiffness.size() == 0) return;
  RequireOnePerVertex(stiffness.size(), source_vertices, what + ": the stiffness map has", "values",
                      "the source", "; paint it on the source mesh");
  for (Eigen::Index i = 0; i < stiffness.size(); ++i)
    if (!(stiffness[i] > 0) || !std::isfinite(stiffness[i]))
      throw InputError(what + ": the stiffness of vertex " + std::to_string(i) +
                       " must be a number above 0; paint it again");
}

}  // namespace keypose
