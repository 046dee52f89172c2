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

struct ShapeJoinOptions {
  int rotations = 240;  ///< starts, spread evenly over all turns
  int coarse_points = 300, fine_points = 2000;
  double kept = 0.6;           ///< share of the pairs, nearest first, that a step is fitted to: each half saw what the other did not
  double max_distance = 0.02;  ///< of pairs that agree, over the first model's spread; at least twice its points' spacing
  double max_color = 0.06;     ///< between their shares of red, green and blue, which light hardly changes
  double min_share = 0.35;     ///< of the points that must agree
  double max_rival = 0.85;     ///< what the next best turn may reach of the best one's agreement
};

/// The motion under which the coloured points of two metric models agree, where their photographs share too few features: trimmed ICP from
/// turns all round, judged by points that agree in place and colour. `pairs` counts the second model's points.
/// Source: Chetverikov et al., "The trimmed iterative closest point algorithm", ICPR 2002. Same bits for any thread count.
Join JoinByShape(const Scene& first, const Scene& second, const ShapeJoinOptions& options);

}  // namespace keypose::reconstruct
