// What makes a mesh, or what is said about its vertices, unusable. Each check throws an InputError
// that says what is wrong, where, and what to do; `what` begins the message and names the place, as
// in "register: source".
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"

namespace keypose {

/// Throws what makes a mesh unusable by any algorithm.
/// @throws InputError  no vertices, no faces, an index out of range, or a vertex not finite or
/// beyond limits.h
void RequireUsable(const Mesh& mesh, const std::string& what);

/// @throws InputError  a vertex that is not finite
void RequireFinite(const PointsX3& points, const std::string& what);

/// @throws InputError  a face that names a vertex below 0, or not below `vertex_count`
void RequireIndices(Eigen::Index vertex_count, const FacesX3& faces, const std::string& what);

/// @param owner   whose vertices they are, with its verb, as in "the keys have"
/// @param remedy  the end of the message, from its "; " on; may be empty
/// @throws InputError  `vertex` below 0, or not below `vertex_count`
void RequireVertex(Eigen::Index vertex, Eigen::Index vertex_count, const std::string& what,
                   const std::string& owner, const std::string& remedy);

/// @param what   with its verb, as in "synth: the registered mesh has"
/// @param unit   what is counted, as in "vertices"
/// @param owner  which mesh has one for each of its vertices
/// @throws InputError  `count` is not that mesh's vertex count
void RequireOnePerVertex(Eigen::Index count, Eigen::Index vertex_count, const std::string& what,
                         const std::string& unit, const std::string& owner,
                         const std::string& remedy);

/// @throws InputError  all faces without area
void RequireArea(const Mesh& mesh, const std::string& what);

/// @throws InputError  all vertices at one place
void RequireExtent(const Mesh& mesh, const std::string& what);

/// @throws InputError  not 0 or more, or not finite; `what` names the number
void RequireNotNegative(double number, const std::string& what);

/// @param source_vertices  of the mesh that is bent
/// @throws InputError  a landmark on a vertex that is not there, or not finite
void RequireUsable(const std::vector<LandmarkGoal>& landmarks, Eigen::Index source_vertices,
                   const std::string& what);

/// @param stiffness  empty: the same everywhere
/// @throws InputError  not one value for each vertex, or not positive and finite
void RequireStiffness(const Eigen::VectorXd& stiffness, Eigen::Index source_vertices,
                      const std::string& what);

}  // namespace keypose
