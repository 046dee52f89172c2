// Bundle adjustment of a turntable capture with few unknowns: one pose per ring, one angle per
// view, one camera.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

struct RingBundleOptions {
  int max_iterations = 30;
  double robust_px = 1;  ///< Cauchy loss
  /// standard deviation of the table's angles from even steps
  double angle_prior_deg = 0.6;
  /// standard deviation of the even step from 360 degrees over the number of positions
  double step_prior_deg = 0.5;
  double noise_px = 0.5;      ///< of features; the priors' weights are relative to it
  bool refine_camera = true;  ///< fx = fy and k1
  double focal_px = 0;        ///< known focal length; 0: the model's
  double focal_prior = 0.03;  ///< its relative standard deviation; constrains the focal length when
                              ///< there are few points
  double k1_prior = 0.05;     ///< standard deviation of k1 about 0
  double max_error_px = 3;    ///< observations with larger errors are dropped before a second solve
};

struct RingBundleResult {
  RingModel model;
  /// in the table's frame; points that keep fewer than two observations do not move
  std::vector<SparsePoint> points;
  std::vector<Observation> observations;  ///< kept
  double mean_error_px = 0;
  double chi2 = 0;               ///< sum of Cauchy losses over the observations kept [px^2]
  int unknowns = 0;              ///< of the cameras, without points
  std::vector<double> slop_rad;  ///< by view: angle minus that of an even step
};

/// Refines a ring model: 6 unknowns for each ring's camera, step and angles with priors, focal
/// length and k1. The gauge is fixed by the priors of the angles (rotation), by a constant distance
/// of the first ring, and by keeping the axis' origin opposite its camera.
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
