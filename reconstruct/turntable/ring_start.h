// A ring model from point matches alone, using the few matches of all pairs together.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/progress.h"
#include "core/values/tuned.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

/// Matched pixels of two images; some matches may be wrong.
struct PairPoints {
  int first = 0, second = 0;                                     ///< images, first < second
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> xy;  ///< N x (x1, y1, x2, y2) [px]
};

/// The pixels of matched features.
std::vector<PairPoints> PointsOf(const std::vector<PairMatches>& matches,
                                 const std::vector<Features>& features);

/// No record of the data. Sensitivity: docs/results/sensitivity.md.
struct RingStartTuning {
  KEYPOSE_TUNED(double, kInlier_px, 3);    ///< largest distance of an inlier from its epipolar line
  KEYPOSE_TUNED(int, kFewestInliers, 40);  ///< a wrong model has fewer by chance
  KEYPOSE_TUNED(double, kLeastInlierShare, 0.25);  ///< of the matches, likewise
};

struct RingStart {
  RingModel model;
  int matches = 0;  ///< number of tested matches
  int inliers = 0;  ///< number of inliers at the end
  double inlier_share = 0;
  bool joined = true;  ///< whether matches connect the rings
  /// Whether there are more inliers than a wrong model would have by chance.
  bool IsPlausible() const {
    return joined && inliers >= RingStartTuning::kFewestInliers &&
           inlier_share > RingStartTuning::kLeastInlierShare;
  }
};

/// Fits a ring model to matches. For each ring, the axis in its camera's frame is searched over the
/// whole sphere. A ring with known steps has only three unknowns: two of the axis' direction and
/// one of its position; the scale is free. The cost is the truncated epipolar error of the matches
/// of all pairs. Then the table's angle at each view is estimated, and then the pose of each
/// further ring from matches across rings (rotation, height and scale).
///
/// @param camera  intrinsics, not changed
/// @return rings' cameras at distance 1 (the first ring's) from the axis
/// Cost: some 10^5 hypotheses with several hundred matches each, on all cores; same bits for any
/// thread count.
RingStart FindRingModel(const Camera& camera, const RingLayout& layout,
                        const std::vector<PairPoints>& pairs, Progress* progress = nullptr);

/// Rows of a pair's matches within `max_error_px` (Sampson distance) of the model's epipolar lines.
std::vector<int> RingInliers(const RingModel& model, const RingView& first, const RingView& second,
                             const PairPoints& pair, double max_error_px);

}  // namespace keypose::reconstruct
