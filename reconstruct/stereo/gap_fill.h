// Smooth surface over gaps of the depth maps that reliable depths surround: what a photograph
// without texture still tells.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/stereo/plane_map.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

/// between the hull's (0.1) and what stereo is sure of (0.3)
constexpr float kGapConfidence = 0.2f;
constexpr int kCellPixels = 4;

/// Confirmed depths of a view, one for each cell of 4 x 4 pixels of level 0.
struct SurfaceCells {
  int width = 0, height = 0;
  std::vector<float> inverse_depth;  ///< at the cell's middle; 0 unknown but in the mask: a gap;
                                     ///< negative: at the mask's rim or outside
  float At(int x, int y) const { return inverse_depth[static_cast<std::size_t>(y) * width + x]; }
};

/// @param confirmed  1 for each pixel of level 0 whose depth other views confirm
SurfaceCells CellsOf(const PreparedView& view, const PlaneMap& map,
                     const std::vector<char>& confirmed);

struct GapFillOptions {
  int reach = 6;                ///< cells; gaps up to about twice as wide are bridged
  double largest_residual = 1;  ///< of the surroundings to their smooth surface, pixels on the
                                ///< surface; more is an edge or noise
  double largest_error = 1;     ///< of the surface in the gap, by the fit
  double agreement = 2;  ///< largest distance between what two views say, pixels on the surface
  int least_views = 3;   ///< that agree on a point, the one that it comes from included
};

/// One point a cell for gaps that known cells surround (no three of eight directions beside each
/// other are empty): a quadric in inverse depth, least squares over the cells around, weighted by a
/// Gaussian. A point needs other views whose depths, or own bridges, agree with it, and none that
/// sees the background there or a surface behind it. Points that several views bridge are given
/// once.
/// @param cells  of each view; empty where it has no map
/// @return confidence kGapConfidence, normals towards the cameras.
/// Same bits for any thread count. In the manner of the planar prior of Xu & Tao, AAAI 2020;
/// departs: a smooth fit to depths that views confirmed, in place of triangles through sparse ones
/// that only guide a further matching, since there is nothing to match.
PointCloud FillGaps(const std::vector<PreparedView>& views,
                    const std::vector<std::vector<int>>& sources,
                    const std::vector<SurfaceCells>& cells, const GapFillOptions& options);

}  // namespace keypose::reconstruct
