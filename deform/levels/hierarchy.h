// Coarser and coarser meshes of one surface, and how motion goes back from coarse to fine.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose {

/// One level: a mesh whose vertices are some of the finer level's.
struct CoarseLevel {
  PointsX3 points;        ///< V x 3, at rest
  FacesX3 faces;          ///< F x 3, oriented as the fine mesh is
  std::vector<int> fine;  ///< V, the vertex of the *input* mesh that each one is
  std::vector<int> up;  ///< for each vertex of the next finer level, the vertex of this level into
                        ///< which it collapsed
};

/// Levels from fine to coarse by half-edge collapses; the input mesh itself is not among them.
///
/// @param counts  wanted vertex counts, falling; a level is left out when the mesh cannot be
/// decimated that far (parts keep 4 vertices each) Vertices are never moved, so a coarse vertex is
/// a vertex of the input. Works on open and non-manifold meshes (collapses that would change how
/// the surface hangs together are refused). Deterministic.
/// Cost: about 4 us a vertex.
/// Source: quadric error metric, Garland and Heckbert 1997; half-edge collapses as in Kobbelt et
/// al. 1998.
std::vector<CoarseLevel> MakeHierarchy(const PointsX3& points, const FacesX3& faces,
                                       const std::vector<int>& counts);

/// How each fine vertex follows a few coarse ones: p = sum_k w_k (R_k (rest - rest_k) + p_k).
struct Prolongation {
  static constexpr int kNodes = 8;
  std::vector<int> offset;    ///< fine V + 1, into node and weight
  std::vector<int> node;      ///< coarse vertices
  std::vector<float> weight;  ///< positive, summing to 1 for each fine vertex
};

/// Fine vertices follow the coarse vertex that they collapsed into and its neighbours, by distance
/// at rest.
Prolongation MakeProlongation(const PointsX3& fine_points, const CoarseLevel& coarse);

/// Positions of the finer level from positions and rotations of the coarse one.
PointsX3 Prolong(const Prolongation& prolongation, const PointsX3& fine_rest,
                 const PointsX3& coarse_rest, const PointsX3& coarse_moved,
                 const std::vector<Eigen::Matrix3d>& rotations);

}  // namespace keypose
