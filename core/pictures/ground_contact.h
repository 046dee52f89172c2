// Estimates the height of the ground that a figure stands on, from the figure's masks.
#pragma once

#include <optional>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose {

/// The lower end of the figure in its photographs.
struct GroundContact {
  double height = 0;  ///< of the ground, along the world's z
  double spread = 0;  ///< median absolute deviation of the views' heights from `height`
  int views = 0;      ///< number of views that gave a height
};

/// The lower border of a mask shows where the soles end, if the camera looks down. Each ray through
/// this border enters the visual hull of all masks at some height. The view's height is the lowest
/// height at which many of these entry points lie close together. A sole with a round edge seems to
/// end higher in steeper views. So a line is fitted to the views' heights over the slopes of their
/// rays (median over pairs of views), and is evaluated for a horizontal view. The visual hull
/// reaches below the ground by about radius x tan(elevation), because no photograph looks there.
///
/// @param views  cameras in a world whose z is up
/// @param masks  one for each view: 1 channel, above 127 where the figure is, of any size with the
/// view's aspect ratio; empty: the view is ignored
/// @param low, high  approximate bounding box of the figure (an error of a tenth of its height is
/// allowed)
/// @return nothing when fewer than 3 views look down at the figure and show its lower border
/// Cost: quadratic in the number of views, of which at most 48 are used, evenly selected.
/// Same bits for any thread count.
std::optional<GroundContact> FindGroundContact(const std::vector<View>& views,
                                               const std::vector<Image8>& masks,
                                               const Eigen::Vector3d& low,
                                               const Eigen::Vector3d& high);

}  // namespace keypose
