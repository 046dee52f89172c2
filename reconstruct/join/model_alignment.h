// Aligns two models of one figure, shot upright and lying, by their common surface.
#pragma once

#include <utility>
#include <vector>

#include "core/values/camera.h"
#include "reconstruct/matching/colmap_database.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

/// A feature of an image that shows a point of a model; images are counted in the set, from 0.
struct TrackElement {
  int image = 0, feature = 0, point = 0;
};

struct AlignmentOptions {
  /// between points that agree, over the spread (rms radius) of the first model's points
  double max_distance = 0.01;
  int trials = 4000;
  int min_pairs = 12;      ///< least number of agreeing pairs
  bool with_scale = true;  ///< false when both models are metric
};

struct ModelAlignment {
  bool found = false;
  Similarity3 first_from_second;
  int pairs = 0, agreeing = 0;
  double rms = 0;  ///< of the agreeing pairs, in the first model's units
  double miss_px = 0,
         /// by outlines: MissedOutlines of this alignment, and of the best one with a different
         /// rotation
      rival_miss_px = 0;
};

/// Pairs (point of the first model, point of the second) connected by matches, those with most
/// matches first; each point is in at most one pair. The matches need no geometric verification:
/// light and view differ so much between placements that hardly any pair of photographs has enough
/// matches for it, but AlignModels checks the matches of all pairs together.
std::vector<std::pair<int, int>> MatchPoints(const std::vector<TrackElement>& first,
                                             const std::vector<TrackElement>& second,
                                             const std::vector<PairMatches>& matches);

/// The similarity with most agreeing pairs: RANSAC over triples, then least squares over the
/// inliers until they no longer change.
/// Source: Fischler & Bolles 1981; Umeyama 1991.
/// Same bits at every call.
ModelAlignment AlignModels(const Scene& first, const Scene& second,
                           const std::vector<std::pair<int, int>>& pairs,
                           const AlignmentOptions& options);

struct ShapeAlignmentOptions {
  int rotations = 240;  ///< starts, evenly distributed over all rotations
  int coarse_points = 300, fine_points = 2000;
  double kept = 0.6;  ///< share of the pairs, nearest first, that a step is fitted to: each model
                      ///< has parts that the other lacks
  double max_distance = 0.02;  ///< of pairs that agree, over the first model's spread; at least
                               ///< twice its points' spacing
  /// between their chromaticities, which hardly depend on light
  double max_color = 0.06;
  double min_share = 0.35;  ///< least share of points that agree
  /// largest agreement of the next best rotation, relative to the best one's
  double max_rival = 0.85;
};

/// The motion that aligns the coloured points of two metric models whose photographs share too few
/// features: trimmed ICP from starts over all rotations, compared by the number of points that
/// agree in position and colour. `pairs` is the number of the second model's points.
/// Source: Chetverikov et al., "The trimmed iterative closest point algorithm", ICPR 2002.
/// Same bits for any thread count.
ModelAlignment AlignByShape(const Scene& first, const Scene& second,
                            const ShapeAlignmentOptions& options);

/// Outlines of both models, each in its own model's frame.
struct HalfOutlines {
  const Silhouettes& first;
  const Silhouettes& second;
};

/// Distance of each model's points outside of the other model's masks [px of the masks], the mean
/// over both, with at most 12 per point. The surface that one model's cameras see must project
/// inside all masks of the other. If a model is too large, its points fall outside of the other's
/// masks; if it is too small, the other's points fall outside of its own. So the distance also
/// determines the scale.
/// @param points  largest number of points of each model
double MissedOutlines(const Scene& first, const Scene& second, const HalfOutlines& outlines,
                      const Similarity3& first_from_second, int points);

struct OutlineAlignmentOptions {
  int rotations = 400;  ///< starts, evenly distributed over all rotations
  int coarse_points = 50, fine_points = 400;
  double max_miss_px = 0.5;   ///< largest excess over the distance of the points outside of their
                              ///< own model's outlines
  double least_rival_px = 1;  ///< least excess of any other rotation over the best
  /// of pairs that agree in position and colour, as in ShapeAlignmentOptions
  double max_distance = 0.02;
  double max_color = 0.06;
  double min_share = 0.25;  ///< least share of points that agree: lower, since sparse points of two
                            ///< mapper models lie farther apart
};

/// The similarity that moves each model's points inside of the other's outlines, for models that
/// are both non-metric: simplex searches from starts over all rotations, then point-to-plane steps
/// over the points that agree in position and colour.
/// @return found only if the outlines fit nearly as well as each model's own points fit its own
/// outlines, no other rotation is nearly as good, and enough points agree in position and colour
/// Cost: some 50,000 evaluations of 100 points in all masks.
/// Same bits for any thread count.
ModelAlignment AlignByOutlines(const Scene& first, const Scene& second,
                               const HalfOutlines& outlines,
                               const OutlineAlignmentOptions& options);

}  // namespace keypose::reconstruct
