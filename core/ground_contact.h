// How high the ground is on which a figure stands, told by its outlines.
#pragma once

#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/image.h"

namespace keypose {

/// Where the figure ends below, by its photographs.
struct GroundContact {
  double height = 0;  ///< of the ground, along the world's z
  double spread = 0;  ///< median deviation of the single views' heights from it
  int views = 0;      ///< that tell of it
};

/// Each photograph from above shows, at the lower rim of the outline, where the soles end. The
/// rim's lines of sight first meet the hull of all masks there; the lowest height at which they
/// crowd is the view's. A sole with a round edge is seen to end the higher, the steeper the view: a
/// line through the views' heights over their slopes (medians of pairs) tells where level views
/// would see its end. Below it the hull goes on by about radius x tan(elevation), where no
/// photograph looks.
///
/// @param views  cameras in a world whose z is up
/// @param masks  one a view, 1 channel, above 127 where the figure is; empty for a view without
/// say; of any size of the view's shape
/// @param low, high  box of the figure, roughly (a tenth of its height is enough)
/// @return nothing when fewer than 3 views look down at the figure and show its lower rim
/// Cost: about views^2; views beyond 48 are thinned evenly.
/// Same bits for any thread count.
std::optional<GroundContact> FindGroundContact(const std::vector<View>& views,
                                               const std::vector<Image8>& masks,
                                               const Eigen::Vector3d& low,
                                               const Eigen::Vector3d& high);

}  // namespace keypose
