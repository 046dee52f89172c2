// Checks whether a mesh, or data about its vertices, is usable. Each check throws an InputError
// that says what is wrong, where, and what to do. `what` is the start of the message and names the
// place, as in "register: source".
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose {

/// Checks what every algorithm needs.
/// @throws InputError  no vertices, no faces, an index out of range, or a vertex that is not finite
/// or beyond kMostCoordinate (coordinate_limit.h)
void RequireUsable(const Mesh& mesh, const std::string& what);

/// @throws InputError  a vertex that is not finite
void RequireFinite(const PointsX3& points, const std::string& what);

/// @throws InputError  a face with a vertex index below 0, or not below `vertex_count`
void RequireIndices(Eigen::Index vertex_count, const FacesX3& faces, const std::string& what);

/// @param owner  the owner of the vertices, with its verb, as in "the keys have"
/// @param remedy  the end of the message, starting with "; "; may be empty
/// @throws InputError  `vertex` is below 0, or not below `vertex_count`
void RequireVertex(Eigen::Index vertex, Eigen::Index vertex_count, const std::string& what,
                   const std::string& owner, const std::string& remedy);

/// @param what  with its verb, as in "synth: the registered mesh has"
/// @param unit  what is counted, as in "vertices"
/// @param owner  the mesh that needs one for each of its vertices
/// @throws InputError  `count` is not that mesh's vertex count
void RequireOnePerVertex(Eigen::Index count, Eigen::Index vertex_count, const std::string& what,
                         const std::string& unit, const std::string& owner,
                         const std::string& remedy);

/// @throws InputError  no face has an area
void RequireArea(const Mesh& mesh, const std::string& what);

/// @throws InputError  all vertices coincide
void RequireExtent(const Mesh& mesh, const std::string& what);

/// @throws InputError  `number` is negative or not finite; `what` names it
void RequireNotNegative(double number, const std::string& what);

/// @param source_vertices  vertex count of the mesh that is deformed
/// @throws InputError  a landmark on a vertex that does not exist, or one that is not finite
void RequireUsable(const std::vector<LandmarkGoal>& landmarks, Eigen::Index source_vertices,
                   const std::string& what);

/// @param stiffness  empty: the same everywhere
/// @throws InputError  not one value for each vertex, or not positive and finite
void RequireStiffness(const Eigen::VectorXd& stiffness, Eigen::Index source_vertices,
                      const std::string& what);

}  // namespace keypose
