// Bundle adjustment with few shared cameras, a robust loss and removal of outliers; it follows
// COLMAP's mapping.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/progress.h"

namespace keypose::reconstruct {

/// The projection of a point in a view.
struct Observation {
  int view = 0, point = 0;
  Eigen::Vector2d pixel;
};

/// A known point of a rigid body, such as a corner of the printed calibration board, and its
/// projection in a view.
struct BodyObservation {
  int view = 0, body = 0;
  Eigen::Vector3d on_body;
  Eigen::Vector2d pixel;
};

/// Rigid bodies with points known in metres. Body 0 is the world: it fixes position, rotation and
/// scale of the result.
struct Bodies {
  std::vector<Rigid3> world_from_body;
  std::vector<BodyObservation> observations;
  bool fixed = false;  ///< the other bodies do not move either
};

struct BundleOptions {
  int max_iterations = 40;  ///< of each of the two solves; 0: nothing moves
  /// scale of the Cauchy loss, which reduces the influence of larger errors
  double robust_px = 1.0;
  bool refine_principal_point = false;
  bool refine_distortion = false;  ///< k1, k2, p1, p2; else k1 alone
  bool keep_aspect = false;        ///< fy over fx is constant: one focal length is solved for
  double max_error_px = 2;  ///< observations with larger errors are dropped before a second solve
};

struct BundleResult {
  Scene scene;
  std::vector<Observation> kept;       ///< remaining observations, with indices of scene.points
  Bodies bodies;                       ///< as given, with their estimated poses
  double bodies_rms_px = 0;            ///< of their observations
  double before_px = 0, after_px = 0;  ///< mean reprojection errors
  double chi2 = 0;  ///< sum of Cauchy losses at the end, over all given observations in front of
                    ///< their camera [px^2]
  int observations = 0, dropped = 0, iterations = 0;
};

/// Refines all poses, points, and lenses: views whose cameras are equal share one lens.
///
/// @param scene         its points' `views` and `error_px` are set from the
/// remaining observations
/// @param observations  at least two for each point
/// @param bodies        known points in views, in addition to the features or instead of them; may
/// be empty
/// @throws InputError   indices out of range
/// @throws SolverError  Ceres finds no usable solution
/// Cost: one sparse Schur solve per iteration, on one thread, so that the result has the same bits
/// on any number of cores.
/// Source: Triggs et al., "Bundle adjustment: a modern synthesis", 2000; solved by Ceres.
BundleResult AdjustBundle(const Scene& scene, const std::vector<Observation>& observations,
                          const BundleOptions& options, Progress* progress = nullptr,
                          const Bodies& bodies = {});

}  // namespace keypose::reconstruct
