// Smooth surface over gaps of the depth maps that reliable depths surround, where photographs have
// no texture.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"
#include "views/stereo/plane_map.h"

namespace keypose::reconstruct {

/// between the hull's (0.1) and that of reliable stereo (0.3)
constexpr float kGapConfidence = 0.2f;
constexpr int kCellPixels = 4;

/// Confirmed depths of a view, one per cell of 4 x 4 pixels of level 0.
struct SurfaceCells {
  int width = 0, height = 0;
  std::vector<float> inverse_depth;  ///< at the cell's middle; 0: unknown but in the mask, a gap;
                                     ///< negative: at the mask's border or outside
  float At(int x, int y) const { return inverse_depth[static_cast<std::size_t>(y) * width + x]; }
};

/// @param confirmed  1 for each pixel of level 0 whose depth other views confirmed
SurfaceCells CellsOf(const PreparedView& view, const stereo::PlaneMap& map,
                     const std::vector<char>& confirmed);

struct GapFillOptions {
  int reach = 6;  ///< cells; the widest gaps that are filled have about twice this width
  double largest_residual = 1;  ///< of the surrounding depths to their smooth surface, pixels on
                                ///< the surface; more indicates an edge or noise
  double largest_error = 1;     ///< of the surface in the gap, estimated from the fit
  /// largest distance between the surfaces of two views, pixels on the surface
  double agreement = 2;
  int least_views = 3;  ///< least number of views that agree on a point, its own included
};

/// Fills gaps that known cells surround (no three adjacent ones of the eight directions are empty)
/// with one point per cell. The surface is a quadric in inverse depth, a least-squares fit to the
/// cells around with Gaussian weights. A point needs other views whose depths, or own fits, agree
/// with it, and no view that sees the background there or a surface behind it. Several views' fits
/// of the same point give one point.
/// @param cells  of each view; empty where it has no map
/// @return points with confidence kGapConfidence and normals towards the cameras
/// Same bits for any thread count. Similar to the planar prior of Xu & Tao, AAAI 2020. Departs: a
/// smooth fit to confirmed depths, in place of triangles between sparse points that guide further
/// matching, because here nothing can be matched.
PointCloud FillGaps(const std::vector<PreparedView>& views,
                    const std::vector<std::vector<int>>& sources,
                    const std::vector<SurfaceCells>& cells, const GapFillOptions& options);

}  // namespace keypose::reconstruct
