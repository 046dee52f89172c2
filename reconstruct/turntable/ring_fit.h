// Whether cameras that were found one by one stood on a turntable, and if so, where with the
// turntable's few unknowns.
#pragma once

#include <vector>

#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/turntable/leveling.h"
#include "reconstruct/turntable/ring_bundle.h"

namespace keypose::reconstruct {

/// The ring model nearest to cameras: for each ring the camera of its middle, and each view's
/// angle. Views of no ring make one of their own.
///
/// @param leveling  of the scene
/// @return in the levelled frame, in which the axis is z; with square pixels
RingModel NearestRingModel(const Scene& scene, const Leveling& leveling);

struct RingFitOptions {
  RingBundleOptions ring;
  BundleOptions bundle;        ///< of the free cameras
  double release_share = 0.8;  ///< cameras stay free when chi^2 per degree of freedom is below this
                               ///< share of the ring model's
  double most_off_axis = 0.01;  ///< of the camera distance, off the rings' planes and circles:
                                ///< beyond, no ring is tried
};

struct RingFit {
  bool tried = false;     ///< the cameras lie on rings, roughly
  bool is_ring = false;   ///< and the data do not ask for more freedom
  double chi2_ratio = 0;  ///< free over ring, per degree of freedom; 0 where no ring was tried
  double ring_px = 0;     ///< mean reprojection error of the ring model
  BundleResult result;    ///< in the frame of the scene given
};

/// Adjusts the scene with free cameras, and as a turntable where the cameras form rings; keeps the
/// ring model unless free cameras fit so much better that the data speak against it (chi^2 per
/// degree of freedom).
///
/// A ring has about 6 unknowns and one for each view instead of 6 for each view: what a view's own
/// features leave open, the others tell.
RingFit AdjustOnRings(const Scene& scene, const std::vector<Observation>& observations,
                      const RingFitOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
