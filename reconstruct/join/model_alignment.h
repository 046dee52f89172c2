// Two models of one figure, shot upright and lying, brought together by what both saw of it.
#pragma once

#include <utility>
#include <vector>

#include "core/camera.h"
#include "reconstruct/matching/colmap_database.h"
#include "views/hull/silhouettes.h"

namespace keypose::reconstruct {

/// A feature of an image that shows a point of a model; image counts in the set, from 0.
struct TrackElement {
  int image = 0, feature = 0, point = 0;
};

struct AlignmentOptions {
  /// between points that agree, over the spread of the first model's points
  double max_distance = 0.01;
  int trials = 4000;
  int min_pairs = 12;      ///< that agree
  bool with_scale = true;  ///< false when both models are metric
};

struct ModelAlignment {
  bool found = false;
  Similarity3 first_from_second;
  int pairs = 0, agreeing = 0;
  double rms = 0;  ///< of the agreeing pairs, in the first model's units
  double miss_px = 0,
         /// by outlines: MissedOutlines of the join, and of the best other turn
      rival_miss_px = 0;
};

/// Pairs (point of the first model, point of the second) that matches join, most votes first; each
/// point in one pair at most. The matches need no geometric test of their own: light and view
/// differ much between placements, so that hardly a pair of photographs has enough of them to stand
/// one, but AlignModels looks at those of all pairs together.
std::vector<std::pair<int, int>> MatchPoints(const std::vector<TrackElement>& first,
                                             const std::vector<TrackElement>& second,
                                             const std::vector<PairMatches>& matches);

/// The similarity under which most pairs agree: RANSAC over triples, then least squares over those
/// that agree, until they stay the same.
/// Source: Fischler & Bolles 1981; Umeyama 1991.
/// Same bits at every call.
ModelAlignment AlignModels(const Scene& first, const Scene& second,
                           const std::vector<std::pair<int, int>>& pairs,
                           const AlignmentOptions& options);

struct ShapeAlignmentOptions {
  int rotations = 240;  ///< starts, spread evenly over all turns
  int coarse_points = 300, fine_points = 2000;
  double kept = 0.6;  ///< share of the pairs, nearest first, that a step is fitted to: each half
                      ///< saw what the other did not
  double max_distance = 0.02;  ///< of pairs that agree, over the first model's spread; at least
                               ///< twice its points' spacing
  /// between their shares of red, green and blue, which light hardly changes
  double max_color = 0.06;
  double min_share = 0.35;  ///< of the points that must agree
  double max_rival = 0.85;  ///< what the next best turn may reach of the best one's agreement
};

/// The motion under which the coloured points of two metric models agree, where their photographs
/// share too few features: trimmed ICP from turns all round, judged by points that agree in place
/// and colour. `pairs` counts the second model's points.
/// Source: Chetverikov et al., "The trimmed iterative closest point algorithm", ICPR 2002.
/// Same bits for any thread count.
ModelAlignment AlignByShape(const Scene& first, const Scene& second,
                            const ShapeAlignmentOptions& options);

/// Outlines of both halves, each in its own model's frame.
struct HalfOutlines {
  const Silhouettes& first;
  const Silhouettes& second;
};

/// By how much the points of each half lie outside of the other half's masks [px of the masks], the
/// mean over both, each point 12 at most. What one half's cameras see of the figure must lie within
/// all masks of the other. Points of a half that is too large fall outside of the other's masks,
/// and of one that is too small the other's outside of its own: so this tells the scale too.
/// @param points  of each half, at most
double MissedOutlines(const Scene& first, const Scene& second, const HalfOutlines& outlines,
                      const Similarity3& first_from_second, int points);

struct OutlineAlignmentOptions {
  int rotations = 400;  ///< starts, spread evenly over all turns
  int coarse_points = 50, fine_points = 400;
  double max_miss_px = 0.5;   ///< beyond what the points miss their own half's outlines by
  double least_rival_px = 1;  ///< any other turn misses by so much more than the best
  /// of pairs that agree in place and colour, as in ShapeAlignmentOptions
  double max_distance = 0.02;
  double max_color = 0.06;
  double min_share = 0.25;  ///< of the points that must agree: lower, since sparse points of two
                            ///< mappers lie farther apart
};

/// The similarity under which each half's points lie within the other half's outlines, for models
/// of which neither is metric: simplex searches from turns all round, then point-to-plane steps
/// over the points that agree in place and colour.
/// @return not found unless the outlines agree nearly as well as each half's do with its own
/// points, no other turn comes near to that, and enough points agree in place and colour Cost: some
/// 50,000 evaluations of 100 points in all masks; same bits for any thread count.
ModelAlignment AlignByOutlines(const Scene& first, const Scene& second,
                               const HalfOutlines& outlines,
                               const OutlineAlignmentOptions& options);

}  // namespace keypose::reconstruct
