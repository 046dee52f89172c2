// Bundle adjustment of one shared camera, with a robust loss and a second look at outliers: what
// follows COLMAP's mapping.
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

/// A known point of a rigid body, such as a corner of the printed calibration board, and where a
/// view shows it.
struct BodyObservation {
  int view = 0, body = 0;
  Eigen::Vector3d on_body;
  Eigen::Vector2d pixel;
};

/// Rigid bodies whose points are known in metres. Body 0 is the world: it fixes place, turn and
/// scale of the result.
struct Bodies {
  std::vector<Rigid3> world_from_body;
  std::vector<BodyObservation> observations;
  bool fixed = false;  ///< the other bodies stay too
};

struct BundleOptions {
  int max_iterations = 40;  ///< of each of the two solves; 0 leaves everything where it is
  double robust_px = 1.0;   ///< Cauchy loss: errors well above this count little
  bool refine_principal_point = false;
  bool refine_distortion = false;  ///< k1, k2, p1, p2; else k1 alone
  bool keep_aspect = false;        ///< fy over fx stays: one focal length is solved for
  double max_error_px = 2;         ///< observations beyond are dropped, and all is solved once more
};

struct BundleResult {
  Scene scene;
  std::vector<Observation> kept;       ///< observations that stay, by the numbers of scene.points
  Bodies bodies;                       ///< as given, with the bodies where they were found to be
  double bodies_rms_px = 0;            ///< of their observations
  double before_px = 0, after_px = 0;  ///< mean reprojection errors
  double chi2 = 0;  ///< sum of Cauchy losses at the end, over all observations given that lie
                    ///< before their camera [px^2]
  int observations = 0, dropped = 0, iterations = 0;
};

/// Refines all cameras, points, and the one camera that all views share.
///
/// @param scene         cameras all equal; its points' `views` and `error_px` are set anew from the
/// observations that stay
/// @param observations  at least two for each point
/// @param bodies        known points that views show, besides the features or instead of them; may
/// be none
/// @throws InputError   indices out of range, or cameras that differ
/// @throws SolverError  Ceres finds no usable solution
/// Cost: one sparse Schur solve per iteration, on one thread, so that the result has the same bits
/// on any number of cores.
/// Source: Triggs et al., "Bundle adjustment: a modern synthesis", 2000; solved by Ceres.
BundleResult AdjustBundle(const Scene& scene, const std::vector<Observation>& observations,
                          const BundleOptions& options, Progress* progress = nullptr,
                          const Bodies& bodies = {});

}  // namespace keypose::reconstruct
