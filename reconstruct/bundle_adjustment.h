// Bundle adjustment of one shared camera, with a robust loss and a second look at outliers: what follows COLMAP's mapping.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/progress.h"

namespace keypose::reconstruct {

/// A feature that shows a point.
struct Observation {
  int view = 0, point = 0;
  Eigen::Vector2d pixel;
};

struct BundleOptions {
  int max_iterations = 40;
  double robust_px = 1.0;  ///< Cauchy loss: errors well above this count little
  bool refine_principal_point = false;
  bool refine_distortion = false;  ///< k1, k2, p1, p2; else k1 alone
  double max_error_px = 2;         ///< observations beyond are dropped, and all is solved once more
};

struct BundleResult {
  Scene scene;
  double before_px = 0, after_px = 0;  ///< mean reprojection errors
  int observations = 0, dropped = 0, iterations = 0;
};

/// Refines all cameras, points, and the one camera that all views share.
///
/// @param scene         cameras all equal; its points' `views` and `error_px` are set anew from the observations that stay
/// @param observations  at least two for each point
/// @throws InputError   indices out of range, or cameras that differ
/// @throws SolverError  Ceres finds no usable solution
/// Cost: one sparse Schur solve per iteration, on one thread, so that the result has the same bits on any number of cores.
/// Source: Triggs et al., "Bundle adjustment: a modern synthesis", 2000; solved by Ceres.
BundleResult AdjustBundle(const Scene& scene, const std::vector<Observation>& observations, const BundleOptions& options,
                          Progress* progress = nullptr);

}  // namespace keypose::reconstruct
