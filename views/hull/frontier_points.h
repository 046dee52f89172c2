// Points where the surface touches the rays through the masks' borders. They are as accurate as the
// masks, independent of texture and gloss.
#pragma once

#include <vector>

#include "views/hull/silhouettes.h"
#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

struct FrontierPointOptions {
  /// a ray point this far outside of the other masks still counts as inside
  double tolerance_px = 0.5;
  /// ray intervals up to this share of the hull's longest side have weight 1
  double sure_length = 0.015;
  double longest_length = 0.03;  ///< longer intervals are too inaccurate: left out
};

struct FrontierPoint {
  Eigen::Vector3d point, normal;  ///< in the world; unit, outwards
  int view = 0;                   ///< the view whose mask border it is on
  double footprint = 0;           ///< size of a pixel at the point, in world units
  double weight = 0;              ///< 0.4 to 1
};

/// Every ray through a mask's border touches the surface somewhere. The other masks leave only an
/// interval of the ray. If that is a single short interval, its middle is close to the surface: the
/// error is a small fraction of the interval's length times the angle between the views that bound
/// it. The interval is tangent to the surface, so errors along it have little effect.
///
/// @param hull  carved with a margin from the views of `silhouettes`
/// @return one point near every second pixel of the masks' borders, view by view
/// Wrong masks give no points: a mask that is too large leaves no interval, a mask that is too
/// small leaves a long one.
/// Source: the frontier points of Cipolla & Giblin, Visual Motion of Curves and Surfaces, 2000,
/// found by bracketing instead of tracking.
std::vector<FrontierPoint> FindFrontierPoints(const VisualHull& hull,
                                              const Silhouettes& silhouettes,
                                              const std::vector<PreparedView>& views,
                                              const FrontierPointOptions& options = {});

}  // namespace keypose
