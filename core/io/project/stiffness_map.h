// Reads a painted stiffness: one factor per vertex.
#pragma once

#include <Eigen/Core>
#include <string>

#include "core/values/mesh.h"

namespace keypose {

/// Reads numbers separated by white space, one for each vertex. '#' starts a comment that ends with
/// the line.
/// @throws InputError  not a number, not positive, or not `vertex_count` numbers; names the line
Eigen::VectorXd ParseStiffness(const std::string& text, int vertex_count, const std::string& name);

/// Reads painted greys: the factor is 8^(luma / 127.5 - 1), so black is 1/8, middle grey 1 and
/// white 8.
/// @throws InputError  no colours, or another number of vertices
Eigen::VectorXd StiffnessFromColors(const Mesh& painted, int vertex_count, const std::string& name);

}  // namespace keypose
