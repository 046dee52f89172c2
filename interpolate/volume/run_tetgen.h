// TetGen in a process of its own.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::interpolation {

struct TetgenMesh {
  std::vector<double> points;  ///< 3 per point; the input's come first
  /// 4 per tetrahedron; a neighbour is behind the face opposite each corner, or -1
  std::vector<int> tets, neighbours;
};

/// Runs TetGen on a closed surface in a forked child process: Debian's TetGen 1.5.0 may crash or
/// not end; the caller is not affected.
/// @param switches  as on TetGen's command line; must contain p, n, z and Q
/// @return nothing if TetGen failed, crashed, or took more than `time_limit_s` of processor time
/// @throws ToolError  no child process could be started
std::optional<TetgenMesh> RunTetgen(const PointsX3& points, const FacesX3& faces,
                                    const std::string& switches, int time_limit_s = 600);

}  // namespace keypose::interpolation
