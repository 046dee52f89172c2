// A painted stiffness that follows the clay: bound to the mesh that it was painted on, and carried
// over to one that was made anew.
#pragma once

#include <string>

#include "core/io/carry_log.h"
#include "core/mesh.h"

namespace keypose {

/// {"schema": 2, "mesh": binding, "stiffness": ["x y z factor", ...]}, one for each vertex.
std::string BoundStiffnessText(const Mesh& mesh, const Eigen::VectorXd& stiffness);

/// Reads what BoundStiffnessText wrote, a PLY's painted greys, or a text of numbers
/// (stiffness_map.h).
///
/// The first two know their mesh: where `source` is another, each of its vertices takes the factor
/// of the nearest vertex there once both are aligned (core/carry.h). Plain numbers are taken as
/// they are, with a warning.
/// @param text     content of the file  @param painted  the file read as a mesh when it is a PLY,
/// else empty
/// @param name     for messages
/// @throws InputError  malformed, another count of plain numbers, or the mesh is of another shape
Eigen::VectorXd StiffnessOn(const Mesh& source, const std::string& text, const Mesh& painted,
                            const std::string& name, CarryLog* log);

}  // namespace keypose
