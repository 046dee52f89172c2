// The curve skeleton of a mesh.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::registration {

/// A curve skeleton as plain arrays.
struct CurveSkeleton {
  PointsX3 nodes;                         ///< N x 3
  std::vector<std::array<int, 2>> edges;  ///< a tree when `fault` is empty
  PointsX3 surface;                       ///< P x 3, points of the decimated surface
  std::vector<int> node_of;               ///< P, the node that each surface point contracted to
  std::string fault;                      ///< why there is no skeleton, or empty
};

/// Contracts a decimated copy of the mesh by mean curvature flow until only curves remain. Holes
/// are capped first.
///
/// @param proxy_faces  faces of the decimated copy; 1,000 take about 30 ms of processor time
/// @param progress     checked for cancel once per round
/// @return the skeleton. `fault` is set for a mesh that is not manifold, is flat or too coarse, has
///         several parts or handles, or cannot be contracted; these do not throw.
/// @throws Cancelled
/// Deterministic.
/// Source: Tagliasacchi, Alhashim, Olson and Zhang, Mean Curvature Skeletons, SGP 2012 (CGAL's
/// implementation).
CurveSkeleton ExtractCurveSkeleton(const PointsX3& points, const FacesX3& faces, int proxy_faces,
                                   Progress* progress = nullptr);

}  // namespace keypose::registration
