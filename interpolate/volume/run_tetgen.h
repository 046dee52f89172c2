// TetGen, kept at arm's length.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/mesh.h"

namespace keypose::interpolation {

struct TetgenMesh {
  std::vector<double> points;  ///< 3 a point; the input's first
  /// 4 a tetrahedron; neighbours: behind the face opposite each corner, or -1
  std::vector<int> tets, neighbours;
};

/// Runs TetGen on a closed surface in a forked child process: Debian's TetGen 1.5.0 frees its
/// memory twice when it refuses an input, and may crash or loop on bad ones; none of that reaches
/// the caller.
/// @param switches  as on TetGen's command line; must hold p, n, z and Q
/// @return nothing where it refused, crashed, or took more than `time_limit_s` of processor time
/// @throws ToolError  no child process could be started
std::optional<TetgenMesh> RunTetgen(const PointsX3& points, const FacesX3& faces,
                                    const std::string& switches, int time_limit_s = 600);

}  // namespace keypose::interpolation
