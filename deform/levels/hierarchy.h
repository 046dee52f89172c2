// A hierarchy of coarser meshes of one surface, and the transfer of motion from coarse to fine.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// One level: a mesh whose vertices are a subset of the finer level's.
struct CoarseLevel {
  PointsX3 points;        ///< V x 3, at rest
  FacesX3 faces;          ///< F x 3, oriented as the fine mesh
  std::vector<int> fine;  ///< V, each vertex's index in the *input* mesh
  std::vector<int> up;  ///< for each vertex of the next finer level, the vertex of this level into
                        ///< which it collapsed
};

/// Makes levels from fine to coarse by half-edge collapses. The input mesh is not among them.
///
/// @param counts  wanted vertex counts, descending; a level is left out when the mesh cannot be
/// decimated that far (each part keeps 4 vertices)
/// Vertices are never moved, so each coarse vertex is a vertex of the input. Works on open and
/// non-manifold meshes. Collapses that would change the topology are refused. Deterministic.
/// Cost: about 4 us per vertex.
/// Source: quadric error metric, Garland and Heckbert 1997; half-edge collapses as in Kobbelt et
/// al. 1998.
std::vector<CoarseLevel> MakeHierarchy(const PointsX3& points, const FacesX3& faces,
                                       const std::vector<int>& counts);

/// Weights by which each fine vertex follows a few coarse ones: p = sum_k w_k (R_k (rest - rest_k)
/// + p_k).
struct Prolongation {
  static constexpr int kNodes = 8;
  std::vector<int> offset;    ///< fine V + 1, into node and weight
  std::vector<int> node;      ///< coarse vertices
  std::vector<float> weight;  ///< positive, with sum 1 for each fine vertex
};

/// Each fine vertex follows the coarse vertex that it collapsed into and that vertex's neighbours.
/// Weights depend on the distances at rest.
Prolongation MakeProlongation(const PointsX3& fine_points, const CoarseLevel& coarse);

/// Positions of the finer level from positions and rotations of the coarse one.
PointsX3 Prolong(const Prolongation& prolongation, const PointsX3& fine_rest,
                 const PointsX3& coarse_rest, const PointsX3& coarse_moved,
                 const std::vector<Eigen::Matrix3d>& rotations);

}  // namespace keypose
