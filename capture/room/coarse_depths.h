// Depths of what photographs of a room show around the figure, coarsely.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/progress.h"

namespace keypose::capture {

struct CoarseDepthOptions {
  int longer_px = 384;      ///< of the pictures that are matched
  int sources = 5;          ///< views that each view is matched with
  double reach = 0.7;       ///< of the cameras' distance: pixels that look past it are left out
  double farthest = 8;      ///< of the cameras' distance: depths up to it are looked for
  double agrees = 0.02;     ///< of the depth: another view's depth confirms it
  double sure_cost = 0.75;  ///< of PatchMatch: windows that match worse are left out
  int confirming = 2;       ///< other views
  /// of the working size: of matches that move less, those that standing still explains as well are
  /// left out
  double near_axis_px = 24;
};

/// Where a pixel's surface is.
struct DepthSample {
  Eigen::Vector2d pixel;    ///< in the photograph at working size, centres at .5
  Eigen::Vector3d point;    ///< in the world
  Eigen::Vector3f outward;  ///< unit normal, towards the camera
  Eigen::Vector3f colour;   ///< RGB, 0 to 255
};

struct CoarseDepths {
  std::vector<std::vector<DepthSample>> views;  ///< by view, row by row
  double pixel = 1;     ///< side of a matched pixel, in pixels of the working size
  double distance = 0;  ///< median of the cameras' distances to the middle
};

/// Matches whole photographs by PatchMatch, and keeps the depths that other views confirm.
/// @param images  RGB at working size, by view
/// @param scene   views with cameras of that size, and sparse points
/// @param middle  on or near the figure
/// Same bits for any thread count on one kind of processor.
CoarseDepths FindCoarseDepths(const std::vector<Image8>& images, const Scene& scene,
                              const Eigen::Vector3d& middle, const CoarseDepthOptions& options = {},
                              Progress* progress = nullptr);

}  // namespace keypose::capture
