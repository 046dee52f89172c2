// PatchMatch multi-view stereo: a depth and a normal for each masked pixel of each view, coarse to
// fine.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "core/progress.h"
#include "reconstruct/stereo/patch_match_sweep.h"
#include "views/hull/depth_bounds.h"

namespace keypose::reconstruct {

struct PatchMatchOptions {
  int coarse_passes = 4;     ///< at the coarsest level, all sources judged
  int fine_passes = 1;       ///< at each finer level, before the geometric ones
  int geometric_passes = 2;  ///< at the finest level; one at the others
  double noise = 0.6;        ///< least standard deviation of noise to reckon with, grey levels
  /// At the finest of several levels windows are narrow where their deviation is this many times
  /// the noise's.
  double narrow_texture = std::numeric_limits<double>::infinity();
  std::uint64_t seed = 1;
};

struct PatchMatchResult {
  std::vector<PlaneMap> maps;  ///< one a view, at level 0, packed; empty for views without sources
  std::int64_t evaluations = 0;  ///< windows correlated
};

/// @param views    all with the same number of levels
/// @param sources  for each view, indices into views, best first, at most kMaxSources; empty: the
/// view gets no map
/// @param bounds   for each view
/// @param seeds    world points that are known to lie on the surface, for each view; may be empty
/// Views run side by side; a geometric pass reads all views' depths as the pass before left them,
/// so thread count changes nothing. Memory at the finest level: 15 bytes a masked pixel of every
/// view and 2.5 bytes a pixel of its crop, and 19 bytes a pixel of the few views at hand.
/// Source: Schoenberger et al., ECCV 2016 (geometric consistency); Xu & Tao, CVPR 2019
/// (multi-scale).
PatchMatchResult EstimatePlanes(const std::vector<PreparedView>& views,
                                const std::vector<std::vector<int>>& sources,
                                const std::vector<DepthBounds>& bounds,
                                const std::vector<std::vector<Eigen::Vector3d>>& seeds,
                                const PatchMatchOptions& options, Progress* progress = nullptr);

}  // namespace keypose::reconstruct
