// Cameras of a turntable capture with too few matches for an incremental mapper: the complete
// ring-model reconstruction.
#pragma once

#include <string>
#include <vector>

#include "core/values/progress.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/descriptor_matching.h"
#include "reconstruct/turntable/ring_bundle.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

struct RingSfmOptions {
  MatchOptions matching;
  RingBundleOptions ring;
  BundleOptions bundle;        ///< of the free cameras
  double release_share = 0.8;  ///< free cameras are used when their chi^2 per degree of freedom
                               ///< falls below this share of the ring model's
  /// largest angle between the viewing directions of pairs that are matched along epipolar lines
  double widest_pair_deg = 60;
  /// a view with fewer observations gets its position from the table's even step alone
  double min_view_matches = 6;
};

struct RingSfmResult {
  bool found = false;  ///< else `start` has the best attempt
  RingLayout layout;
  RingStart start;
  RingModel model;
  Scene scene;         ///< cameras and points, in the table's frame (z the axis)
  bool freed = false;  ///< the free cameras were used
  double ring_error_px = 0, free_error_px = 0;  ///< mean reprojection errors
  double chi2_ratio = 1;                        ///< free over ring, per degree of freedom
  std::vector<double> slop_deg;                 ///< of the ring model's views
  std::vector<std::string> by_step_only;        ///< names of views without observations
};

/// Finds the ring model among the layouts (the one with most inliers), triangulates, adjusts,
/// matches again along the model's epipolar lines, adjusts again, and uses free cameras if they fit
/// much better.
///
/// @param names, features  of all images
/// @param matches   raw matches of pairs of images, also few
/// @param layouts   candidates, at least one
/// Same bits for any thread count.
RingSfmResult ReconstructRing(const Camera& camera, const std::vector<std::string>& names,
                              const std::vector<Features>& features,
                              const std::vector<PairMatches>& matches,
                              const std::vector<RingLayout>& layouts, const RingSfmOptions& options,
                              Progress* progress = nullptr);

}  // namespace keypose::reconstruct
