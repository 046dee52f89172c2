// Lines of sight through the holes of masks: what the photographs see through a figure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose {

/// The line of sight of a pixel that shows background inside of the figure's outline.
struct SightLine {
  Eigen::Vector3d origin;     ///< the camera's centre, in the surface's frame
  Eigen::Vector3d direction;  ///< any length
  int view = 0;
  int hole = 0;  ///< counted over all views: which hole of a mask the pixel lies in
};

/// Lines through the holes of the masks: background that the figure encloses in the picture, at
/// least 2.5 pixels from its rim.
/// @param masks  one a view, 1 channel, above 127 where the figure is; empty for a view without
/// say; of any size of the view's shape
std::vector<SightLine> LinesThroughHoles(const std::vector<View>& views,
                                         const std::vector<Image8>& masks);

/// Holes all of whose lines the surface blocks, ascending.
std::vector<int> ClosedHoles(const Mesh& surface, const std::vector<SightLine>& lines);

/// Views with a hole in the mask all of whose lines the surface blocks, ascending: there it closes
/// a window that the photograph shows.
std::vector<int> ViewsWithClosedWindow(const Mesh& surface, const std::vector<SightLine>& lines);

}  // namespace keypose
