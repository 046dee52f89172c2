// PatchMatch multi-view stereo: a depth and a normal for each masked pixel of each view, from
// coarse to fine.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/values/progress.h"
#include "views/hull/depth_bounds.h"
#include "views/stereo/patch_match_sweep.h"

namespace keypose::stereo {

struct PatchMatchOptions {
  int coarse_passes = 4;     ///< at the coarsest level, with all sources
  int fine_passes = 1;       ///< at each finer level, before the geometric ones
  int geometric_passes = 2;  ///< at the finest level; one at the others
  double noise = 0.6;        ///< least assumed standard deviation of the noise, grey levels
  /// At the finest of several levels, windows are narrow where their standard deviation is at least
  /// this many times the noise's.
  double narrow_texture = std::numeric_limits<double>::infinity();
  std::uint64_t seed = 1;
};

struct PatchMatchResult {
  std::vector<PlaneMap> maps;    ///< one per view, level 0, packed; empty without sources
  std::int64_t evaluations = 0;  ///< number of window correlations
};

/// @param views    all with the same number of levels
/// @param sources  for each view, indices into views, best first, at most kMaxSources; empty: the
/// view gets no map
/// @param bounds   for each view
/// @param seeds    world points that are known to be on the surface, for each view; may be empty
/// Views are processed in parallel. A geometric pass reads the depths of the pass before for all
/// views, so the result does not depend on the thread count. Memory at the finest level: 15 bytes
/// per masked pixel and 2.5 bytes per pixel of the crop for every view, and 19 bytes per pixel for
/// the few views in progress.
/// Source: Schoenberger et al., ECCV 2016 (geometric consistency); Xu & Tao, CVPR 2019
/// (multi-scale).
PatchMatchResult EstimatePlanes(const std::vector<PreparedView>& views,
                                const std::vector<std::vector<int>>& sources,
                                const std::vector<DepthBounds>& bounds,
                                const std::vector<std::vector<Eigen::Vector3d>>& seeds,
                                const PatchMatchOptions& options, Progress* progress = nullptr);

}  // namespace keypose::stereo
