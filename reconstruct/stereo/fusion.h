// Fusion: depth maps that agree become one oriented, coloured cloud.
#pragma once

#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "reconstruct/stereo/gap_fill.h"
#include "reconstruct/stereo/patch_match_sweep.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct FusionOptions {
  int least_views = 3;            ///< that see a point, the reference included
  double reprojection_px = 1.5;   ///< there and back, in the reference
  double depth_tolerance = 0.01;  ///< relative
  double normal_tolerance_deg = 30;
  double largest_cost = 1.0;   ///< pixels that match worse do not take part
  double largest_error = 1.0;  ///< nor those whose depth is expected to be off by more, pixels on
                               ///< the surface; or than the median's
  double window_variance = 0;  ///< of the windows that depths are means over, see
                               ///< WindowBiasOptions; 0: depths are taken as they are
};

struct FusionResult {
  PointCloud cloud;  ///< normals towards the cameras; confidence in (0, 1]: agreement and match
  /// for each view, 1 for each pixel whose depth enough others confirmed
  std::vector<std::vector<char>> confirmed;
  /// of each view: its confirmed depths, coarsely; empty where it has no map
  std::vector<SurfaceCells> cells;
  std::vector<double> completeness;  ///< for each view, the share of masked pixels that were
                                     ///< confirmed; 0 for views without map
};

/// @param maps  packed or not; freed as soon as they are read
/// A pixel is kept when enough of its sources' maps put a surface at the same place with the same
/// normal; those pixels are merged with it and not used again, and a pixel whose neighbours in two
/// views are used already adds nothing. Views are taken in order, pixels row by row: the same bits
/// for any thread count.
/// Source: Merrell et al., ICCV 2007, in the form of Schoenberger et al., ECCV 2016.
FusionResult FuseDepthMaps(const std::vector<PreparedView>& views,
                           const std::vector<std::vector<int>>& sources, std::vector<PlaneMap> maps,
                           const FusionOptions& options);

}  // namespace keypose::reconstruct
