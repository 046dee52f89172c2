// Removes the parts of a reconstructed surface that have no data, and colours the rest.
#pragma once

#include "core/values/mesh.h"
#include "reconstruct/meshing/points.h"

namespace keypose::reconstruct {

struct TrimOptions {
  /// a vertex has no data when no point lies within this many spacings; 0 keeps all
  double trim = 8;
  double keep_area = 0.002;  ///< largest share of the whole area of a patch without data that is
                             ///< kept, as a smooth closure
  /// connected parts with fewer faces than this share of the largest part's are removed
  double min_component = 0.02;
};

struct TrimResult {
  Mesh mesh;
  int trimmed_faces = 0;  ///< without data
  int removed_components = 0;
  int kept_closures = 0;  ///< patches without data that were small enough to keep
};

/// Removes the faces of `surface` that are too far from the points, then the small parts that
/// remain. Vertices are renumbered in order.
///
/// @param cell  edge of the finest octree cell; the least spacing, as the surface is not finer
/// @throws SolverError  nothing is left
/// Same bits for any thread count.
/// Source: the idea of Kazhdan's SurfaceTrimmer, with distance to the points instead of the
/// octree's density, which PCL does not provide.
TrimResult TrimToData(const Mesh& surface, const FilteredPoints& points, double cell,
                      const TrimOptions& options);

/// V x 3 colours: the mean of the nearest points that face the same way, weighted by the inverse
/// square of their distance; empty for a cloud without colours.
ColorsX3 ColorsFromPoints(const Mesh& surface, const FilteredPoints& points);

}  // namespace keypose::reconstruct
