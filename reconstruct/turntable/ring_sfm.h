// Cameras of a turntable capture whose matches are too few for an incremental mapper: the ring
// model from start to end.
#pragma once

#include <string>
#include <vector>

#include "core/progress.h"
#include "reconstruct/bundle/bundle_adjustment.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/matching/descriptor_matching.h"
#include "reconstruct/turntable/ring_bundle.h"
#include "reconstruct/turntable/ring_start.h"

namespace keypose::reconstruct {

struct RingSfmOptions {
  MatchOptions matching;
  RingBundleOptions ring;
  BundleOptions bundle;        ///< of the cameras set free
  double release_share = 0.8;  ///< cameras are freed when chi^2 per degree of freedom falls below
                               ///< this share of the ring model's
  /// between the lines of sight of photographs that are matched along epipolar lines
  double widest_pair_deg = 60;
  /// a view with fewer observations has its place from the table's even step alone
  double min_view_matches = 6;
};

struct RingSfmResult {
  bool found = false;  ///< else `start` says how near it came
  RingLayout layout;
  RingStart start;
  RingModel model;
  Scene scene;         ///< cameras and points, in the table's frame (z the axis)
  bool freed = false;  ///< the cameras left the ring model
  double ring_error_px = 0, free_error_px = 0;  ///< mean reprojection errors
  double chi2_ratio = 1;                        ///< free over ring, per degree of freedom
  std::vector<double> slop_deg;                 ///< of the ring model's views
  std::vector<std::string> by_step_only;  ///< names of views without observations of their own
};

/// Finds the ring model among the layouts (that with most inliers), triangulates, adjusts, matches
/// once more along the model's epipolar lines, adjusts again, and sets the cameras free when the
/// data ask for it.
///
/// @param names, features  of all images
/// @param matches   raw matches of pairs of images, however few
/// @param layouts   candidates, at least one
/// Same bits for any thread count.
RingSfmResult ReconstructRing(const Camera& camera, const std::vector<std::string>& names,
                              const std::vector<Features>& features,
                              const std::vector<PairMatches>& matches,
                              const std::vector<RingLayout>& layouts, const RingSfmOptions& options,
                              Progress* progress = nullptr);

}  // namespace keypose::reconstruct
