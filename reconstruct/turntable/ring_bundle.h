// Bundle adjustment of a turntable capture with few unknowns: a pose for each ring, an angle for
// each view, one camera.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

struct RingBundleOptions {
  int max_iterations = 30;
  double robust_px = 1;  ///< Cauchy loss
  /// how far the table may stand from its even steps: standard deviation
  double angle_prior_deg = 0.6;
  /// how far the even step may be from 360 degrees over the positions
  double step_prior_deg = 0.5;
  double noise_px = 0.5;      ///< of features; what the priors are weighed against
  bool refine_camera = true;  ///< fx = fy and k1
  double focal_px = 0;        ///< what is known of the focal length; 0: the model's
  double focal_prior = 0.03;  ///< its relative standard deviation; holds what few points leave open
  double k1_prior = 0.05;     ///< standard deviation of k1 about 0
  double max_error_px = 3;    ///< observations beyond are dropped, and all is solved once more
};

struct RingBundleResult {
  RingModel model;
  /// in the table's frame; those that keep no two observations stay where they were
  std::vector<SparsePoint> points;
  std::vector<Observation> observations;  ///< kept
  double mean_error_px = 0;
  double chi2 = 0;               ///< sum of Cauchy losses over the observations kept [px^2]
  int unknowns = 0;              ///< of cameras; points not counted
  std::vector<double> slop_rad;  ///< by view: angle less that of an even step
};

/// Refines a ring model: camera 6 for each ring, step and angles with priors, focal length and k1.
/// The gauge is fixed by the priors of the angles (turn) and by holding the first ring's distance
/// and the axis' origin opposite its camera.
///
/// @param points        start, in the table's frame
/// @param observations  `view` counts RingModel::views
/// @throws InputError   indices out of range
/// @throws SolverError  Ceres finds no usable solution
/// Cost: as AdjustBundle with a smaller reduced system; one thread, the same bits on any number of
/// cores.
RingBundleResult AdjustRingBundle(const RingModel& model, const std::vector<SparsePoint>& points,
                                  const std::vector<Observation>& observations,
                                  const RingBundleOptions& options);

/// The views and points of a ring model as a scene in the table's frame. `names` are those of all
/// images.
Scene SceneOf(const RingModel& model, const std::vector<std::string>& names,
              const std::vector<SparsePoint>& points);

}  // namespace keypose::reconstruct
