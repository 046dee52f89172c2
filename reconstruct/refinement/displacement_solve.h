// Displacements of a surface along its normals that fit data with little bending.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "core/values/size_of.h"

namespace keypose::reconstruct {

/// Neighbours of the vertices, in one array: those of v are at [begin[v], begin[v + 1]), ascending.
struct Neighbors {
  std::vector<int> begin, vertex;
  /// mean edge length over the edge's, in [0.25, 4]; the same from both ends
  std::vector<float> weight;
  /// V, one over the sum of a vertex's weights; 0 without neighbours
  std::vector<float> inverse_sum;
  double mean_edge = 0;

  int vertex_count() const { return SizeOf(begin) - 1; }
};
Neighbors MakeNeighbors(const PointsX3& points, const FacesX3& faces);

/// The energy of a displacement d (V values, in `unit`s of length) is
///
///     sum_v weight_v (d_v - target_v)^2 + sum_edges membrane (d_u - d_v)^2
///     + sum_v bending (b_v - b0_v)^2
///
/// with b = n . (mean of neighbours - x) / unit at the displaced positions, and b0 the mean around
/// v of b at the initial positions. So noise of the surface is smoothed where there is no data, and
/// its shape stays. `bending` applies to neighbours at a distance of one unit and is scaled to the
/// mesh's spacing, so that a finer mesh of the same surface is as stiff.
struct DisplacementEnergy {
  double unit = 1, membrane = 0, bending = 0;
  /// + sum_v anchor d_v^2; positive, so that parts without data have a solution
  double anchor = 1e-4;
  std::vector<float> target, weight;
  /// V x 3 unit, or empty: edges should be perpendicular to them, + sum_edges w (m . (x_u - x_v) /
  /// unit)^2 with m and w the means of the ends' values
  PointsX3 slope_normals;
  std::vector<float> slope_weight;  ///< V
};

/// Conjugate gradients, with sums in fixed blocks: the same bits for any thread count.
///
/// @param start  V; changed to the solution
/// @return number of iterations
int SolveDisplacement(const PointsX3& points, const PointsX3& normals, const Neighbors& neighbors,
                      const DisplacementEnergy& energy, std::vector<float>* start);

/// Each round replaces a vertex's value by half of it plus half of its neighbours' weighted mean,
/// on rows of `columns` values. Vertices with use == 0 do not contribute, but receive values.
void Diffuse(const Neighbors& neighbors, int columns, int rounds, const std::vector<char>& use,
             std::vector<float>* values);

}  // namespace keypose::reconstruct
