// Places where the surface touches the rays of the masks' rims: as exact as the masks, whatever the
// texture or gloss.
#pragma once

#include <vector>

#include "views/hull/silhouettes.h"
#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose {

struct FrontierPointOptions {
  double tolerance_px = 0.5;  ///< of the other masks, within which a ray still counts as inside
  /// pieces of rays up to this share of the hull's longest side weigh 1
  double sure_length = 0.015;
  double longest_length = 0.03;  ///< longer ones tell too little: left out
};

struct FrontierPoint {
  Eigen::Vector3d point, normal;  ///< in the world; unit, outwards
  int view = 0;                   ///< whose rim it is
  double footprint = 0;           ///< world length of a pixel there
  double weight = 0;              ///< 0.4 to 1
};

/// Every ray through a mask's rim touches the surface somewhere. The other masks leave only a piece
/// of it; where that is a single short one, its middle lies on the surface but for a small part of
/// the piece's length times the angle between the views that end it. The piece is tangent to the
/// surface, so a place too near or too far along it hardly matters.
///
/// @param hull  carved with a margin from the views of `silhouettes`
/// @return one point near every second pixel of rim, view by view
/// Masks that are wrong give none: where one is too large no piece is left, where it is too small
/// the piece is long.
/// Source: the frontier points of Cipolla & Giblin, Visual Motion of Curves and Surfaces, 2000,
/// found by bracketing instead of tracking.
std::vector<FrontierPoint> FindFrontierPoints(const VisualHull& hull,
                                              const Silhouettes& silhouettes,
                                              const std::vector<PreparedView>& views,
                                              const FrontierPointOptions& options = {});

}  // namespace keypose
