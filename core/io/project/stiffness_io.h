// A painted stiffness together with the mesh that it was painted on. It can be transferred to a
// mesh that was rebuilt since.
#pragma once

#include <filesystem>
#include <string>

#include "core/io/project/carry_log.h"
#include "core/values/mesh.h"

namespace keypose {

/// {"schema": 2, "mesh": binding, "stiffness": ["x y z factor", ...]}, one for each vertex.
std::string BoundStiffnessText(const Mesh& mesh, const Eigen::VectorXd& stiffness);

/// Reads what BoundStiffnessText wrote, a PLY's painted greys, or a text of numbers
/// (stiffness_map.h).
///
/// The first two hold the positions of their vertices. If `source` is another mesh, the two are
/// aligned (core/surfaces/carry.h), and each vertex of `source` takes the factor of the nearest
/// painted vertex. Plain numbers are used unchanged, with a warning.
/// @param text  content of the file
/// @param painted  the file read as a mesh when it is a PLY, else empty
/// @param name  the file's name, for messages
/// @throws InputError  malformed, a wrong count of plain numbers, or a mesh of another shape
Eigen::VectorXd StiffnessOn(const Mesh& source, const std::string& text, const Mesh& painted,
                            const std::string& name, CarryLog* log);

/// The same from a file.
/// @throws DiskError, and as StiffnessOn
Eigen::VectorXd ReadStiffness(const std::filesystem::path& path, const Mesh& source, CarryLog* log);

}  // namespace keypose
