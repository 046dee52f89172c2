// Prepares a fused point cloud for meshing: reports faults, removes outliers, measures the spacing.
#pragma once

#include <string>
#include <vector>

#include "core/values/mesh.h"
#include "core/values/progress.h"

namespace keypose::reconstruct {

struct PointFilterOptions {
  int neighbors = 16;        ///< points from which the local density is measured, >= 4
  double outlier_ratio = 4;  ///< removed: mean distance to the neighbours above this many times the
                             ///< median; 0 keeps all
  double min_confidence = 0;  ///< removed: confidence below this, where the cloud has confidences
  bool thin_unsure = true;  ///< among points below or above more confident ones, keep only a share
                            ///< that depends on the ratio of their confidences
};

/// Points ready for meshing.
struct FilteredPoints {
  PointCloud cloud;
  /// P, distance between neighbouring samples around each point [the cloud's unit]
  Eigen::VectorXd spacing;
  Eigen::VectorXf weights;  ///< P in (0, 1], confidence times the area of the point; empty for a
                            ///< cloud without confidences
  double median_spacing = 0;
  int removed_unsure = 0;        ///< confidence too low
  int removed_outliers = 0;      ///< too far from their neighbours
  int removed_thinned = 0;       ///< less confident than their neighbours
  int merged = 0;                ///< merged with others of their cell
  int removed_contrary = 0;      ///< normal opposite to nearly all of the neighbours' normals
  bool normals_flipped = false;  ///< all normals pointed inside and were reversed
};

/// Checks that a cloud can be meshed.
/// @throws InputError  fewer than 100 points, no normals, a value that is not finite, all points in
/// one place; names `what` and the point
void RequireMeshable(const PointCloud& cloud, const std::string& what);

/// Merges points closer than a mesh of this fineness resolves. Removes outliers, opposite normals
/// and a share of the points that are less confident than their neighbours. Makes normals point
/// outwards, and measures the spacing.
///
/// @param merge_cell  edge of the cells within which points are merged (MergeWithinCells); 0: no
/// merging
/// @throws InputError  as RequireMeshable, or fewer than 100 points are left
/// Cost: two passes of `neighbors`-nearest queries.
/// Same bits for any thread count.
/// Source: the distance rule is Rusu et al. 2008 (statistical outlier removal) with medians instead
/// of means.
FilteredPoints FilterPoints(PointCloud cloud, const PointFilterOptions& options, double merge_cell,
                            const std::string& what, Progress* progress);

}  // namespace keypose::reconstruct
