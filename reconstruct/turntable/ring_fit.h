// Tests whether individually estimated cameras form a turntable, and if so, adjusts them with the
// turntable's few unknowns.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/turntable/leveling.h"
#include "reconstruct/turntable/ring_bundle.h"

namespace keypose::reconstruct {

/// The ring model nearest to given cameras: each ring's mean camera, and each view's angle. Each
/// view of no ring becomes a ring of its own.
///
/// @param leveling  of the scene
/// @return in the levelled frame, in which the axis is z; with square pixels
RingModel NearestRingModel(const Scene& scene, const Leveling& leveling);

struct RingFitOptions {
  RingBundleOptions ring;
  BundleOptions bundle;         ///< of the free cameras
  double release_share = 0.8;   ///< free cameras are used when their chi^2 per degree of freedom is
                                ///< below this share of the ring model's
  double most_off_axis = 0.01;  ///< largest distance from the rings' planes and circles, over the
                                ///< camera distance, for which a ring is tried
};

struct RingFit {
  bool tried = false;     ///< the cameras lie approximately on rings
  bool is_ring = false;   ///< and the data fit the ring model
  double chi2_ratio = 0;  ///< free over ring, per degree of freedom; 0 if no ring was tried
  double ring_px = 0;     ///< mean reprojection error of the ring model
  BundleResult result;    ///< in the frame of the given scene
};

/// Adjusts the scene with free cameras, and with a ring model if the cameras form rings and have
/// one size of picture. Uses the ring model unless free cameras fit much better (chi^2 per degree
/// of freedom).
///
/// A ring has about 6 unknowns plus one per view, instead of 6 per view: parameters that a view's
/// own features do not determine follow from the other views.
RingFit AdjustOnRings(const Scene& scene, const std::vector<Observation>& observations,
                      const RingFitOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
