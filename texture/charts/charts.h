// Cuts a closed surface into charts that are nearly flat.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::texture {

/// Face across edge k (corners k, k + 1) of each face.
/// @param faces  closed oriented 2-manifold
/// @throws InputError  an edge without exactly one opposite; names it
FacesX3 FaceNeighbors(const FacesX3& faces);

/// Surface data for cutting, computed once.
struct Surface {
  PointsX3 points;
  FacesX3 faces, neighbors;
  PointsX3 centers, normals;  ///< F x 3, normals unit (zero where a face has no area)
  Eigen::VectorXd areas;
};
Surface MakeSurface(const Mesh& mesh);

/// A connected part of the surface with its own vertex numbers. A vertex with several fans of faces
/// in the chart becomes one vertex per fan.
struct Chart {
  std::vector<int> faces;     ///< of the surface, ascending
  FacesX3 corners;            ///< local vertices, row i belongs to faces[i]
  std::vector<int> vertices;  ///< of the surface, for each local one
  /// local vertices along the boundary, surface to the left; only when `disk`
  std::vector<int> rim;
  bool disk = false;  ///< connected, one boundary loop, no handle
};
Chart MakeChart(const Surface& surface, std::vector<int> faces);

/// Chart of each face, in [0, count): Lloyd iterations on the dual graph.
/// Source: Sander, Wood, Gortler, Snyder, Hoppe, SGP 2003 (multi-chart geometry images), section 3;
/// seeds are ours.
std::vector<int> CutIntoCharts(const Surface& surface, int count, int rounds);

/// Two connected halves of a chart with at least two faces.
std::vector<std::vector<int>> Halved(const Surface& surface, const std::vector<int>& faces);

}  // namespace keypose::texture
