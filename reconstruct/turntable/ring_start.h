// A ring model from point matches alone, however few a pair has: all pairs vote together.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/progress.h"
#include "reconstruct/matching/colmap_database.h"
#include "reconstruct/turntable/ring_model.h"

namespace keypose::reconstruct {

/// Matched pixels of two images; wrong matches may be among them.
struct PairPoints {
  int first = 0, second = 0;                                     ///< images, first < second
  Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> xy;  ///< N x (x1, y1, x2, y2) [px]
};

/// The pixels of matched features.
std::vector<PairPoints> PointsOf(const std::vector<PairMatches>& matches,
                                 const std::vector<Features>& features);

struct RingStart {
  RingModel model;
  int matches = 0;  ///< looked at
  int inliers = 0;  ///< of those, within 3 px of their epipolar lines at the end
  double inlier_share = 0;
  bool joined = true;  ///< whether rings could be tied to each other by matches
  /// Whether the matches stand out from what a wrong model would gather by chance.
  bool Believable() const { return joined && inliers >= 40 && inlier_share > 0.25; }
};

/// Fits a ring model to matches. For each ring the axis as its camera sees it is sought over the
/// whole sphere (a ring at known steps has but three unknowns: two of the axis' direction, one of
/// its place; the scale is free), judged by truncated epipolar errors of matches of all pairs; then
/// the table's angle at each view; then the place of each further ring by matches across rings
/// (turn, height and scale).
///
/// @param camera  intrinsics, taken as they are
/// @return rings' cameras at distance 1 (the first ring's) from the axis
/// Cost: some 10^5 hypotheses of some hundred matches each, on all cores; same bits for any thread
/// count.
RingStart FindRingModel(const Camera& camera, const RingLayout& layout,
                        const std::vector<PairPoints>& pairs, Progress* progress = nullptr);

/// Rows of a pair's matches within `max_error_px` (Sampson distance) of the model's epipolar lines.
std::vector<int> RingInliers(const RingModel& model, const RingView& first, const RingView& second,
                             const PairPoints& pair, double max_error_px);

}  // namespace keypose::reconstruct
