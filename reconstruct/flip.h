// Two models of one figure, shot upright and lying, brought together by what both saw of it.
#pragma once

#include <utility>
#include <vector>

#include "core/camera.h"
#include "reconstruct/colmap_database.h"

namespace keypose::reconstruct {

/// A feature of an image that shows a point of a model; image counts in the set, from 0.
struct TrackElement {
  int image = 0, feature = 0, point = 0;
};

struct JoinOptions {
  double max_distance = 0.01;  ///< between points that agree, over the spread of the first model's points
  int trials = 4000;
  int min_pairs = 12;      ///< that agree
  bool with_scale = true;  ///< false when both models are metric
};

struct Join {
  bool found = false;
  Similarity3 first_from_second;
  int pairs = 0, agreeing = 0;
  double rms = 0;  ///< of the agreeing pairs, in the first model's units
};

/// Pairs (point of the first model, point of the second) that matches join, most votes first; each point in one pair at most. The matches
/// need no geometric test of their own: light and view differ much between placements, so that hardly a pair of photographs has enough of
/// them to stand one, but JoinModels looks at those of all pairs together.
std::vector<std::pair<int, int>> MatchPoints(const std::vector<TrackElement>& first, const std::vector<TrackElement>& second,
                                             const std::vector<PairMatches>& matches);

/// The similarity under which most pairs agree: RANSAC over triples, then least squares over those that agree, until they stay the same.
/// Source: Fischler & Bolles 1981; Umeyama 1991. Same bits at every call.
Join JoinModels(const Scene& first, const Scene& second, const std::vector<std::pair<int, int>>& pairs, const JoinOptions& options);

}  // namespace keypose::reconstruct
