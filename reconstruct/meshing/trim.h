// Cuts a reconstructed surface back to where there is data, and colours it.
#pragma once

#include "core/mesh.h"
#include "reconstruct/meshing/points.h"

namespace keypose::reconstruct {

struct TrimOptions {
  /// a vertex is without data when no point lies within this many spacings; 0 keeps all
  double trim = 8;
  double keep_area = 0.002;  ///< share of the whole area up to which one patch without data stays,
                             ///< as a smooth closure
  /// connected parts with fewer than this share of the largest part's faces are removed
  double min_component = 0.02;
};

struct TrimResult {
  Mesh mesh;
  int trimmed_faces = 0;  ///< without data
  int removed_components = 0;
  int kept_closures = 0;  ///< patches without data that were small enough to stay
};

/// Removes the faces of `surface` that lie too far from the points, then the small parts that
/// remain. Vertices are renumbered in order.
///
/// @param cell  edge of the finest octree cell; a spacing counts as at least that, as the surface
/// is not finer
/// @throws SolverError  nothing is left
/// Same bits for any thread count.
/// Source: the idea of Kazhdan's SurfaceTrimmer, with distance to the points instead of the
/// octree's density, which PCL does not give.
TrimResult TrimToData(const Mesh& surface, const FilteredPoints& points, double cell,
                      const TrimOptions& options);

/// V x 3 colours: the nearest points that face the same way, weighted by the inverse square of
/// their distance; empty for a cloud without colours.
ColorsX3 ColorsFromPoints(const Mesh& surface, const FilteredPoints& points);

}  // namespace keypose::reconstruct
