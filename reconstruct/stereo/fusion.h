// Fusion: consistent depth maps become one oriented, coloured cloud.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/mesh.h"
#include "reconstruct/stereo/gap_fill.h"
#include "views/prepared/prepared_view.h"
#include "views/stereo/patch_match_sweep.h"

namespace keypose::reconstruct {

struct FusionOptions {
  int least_views = 3;           ///< least number of views that see a point, the reference included
  double reprojection_px = 1.5;  ///< largest forward-backward reprojection error in the reference
  double depth_tolerance = 0.01;  ///< relative
  double normal_tolerance_deg = 30;
  double largest_cost = 1.0;   ///< pixels with a larger matching cost are ignored
  double largest_error = 1.0;  ///< pixels with a larger expected depth error are ignored [pixels on
                               ///< the surface], unless the median error is larger
  double window_variance = 0;  ///< variance of the windows over which depths are averaged, see
                               ///< WindowBiasOptions; 0: no correction
};

struct FusionResult {
  /// normals towards the cameras; confidence in (0, 1]: consistency and matching cost
  PointCloud cloud;
  /// for each view: 1 for each pixel whose depth enough others confirmed
  std::vector<std::vector<char>> confirmed;
  /// for each view: its confirmed depths, coarsely; empty where it has no map
  std::vector<SurfaceCells> cells;
  std::vector<double> completeness;  ///< for each view: the share of masked pixels that were
                                     ///< confirmed; 0 for views without a map
};

/// A pixel is kept when the maps of enough of its sources have a surface at the same place with the
/// same normal. Those pixels are merged with it and not used again. A pixel adds nothing when its
/// counterparts in two views are used already. Views are processed in order, pixels row by row: the
/// same bits for any thread count.
/// @param maps  packed or not; freed as soon as they are read
/// Source: Merrell et al., ICCV 2007, in the form of Schoenberger et al., ECCV 2016.
FusionResult FuseDepthMaps(const std::vector<PreparedView>& views,
                           const std::vector<std::vector<int>>& sources,
                           std::vector<stereo::PlaneMap> maps, const FusionOptions& options);

}  // namespace keypose::reconstruct
