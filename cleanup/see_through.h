// Which handles of a surface the photographs see through: background behind a window is no noise.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::cleanup {

/// The line of sight of a pixel that shows background inside of the figure's outline.
struct SightLine {
  Eigen::Vector3d origin;     ///< the camera's centre, in the surface's frame
  Eigen::Vector3d direction;  ///< any length
  int view = 0;
  int hole = 0;  ///< counted over all views: which hole of a mask the pixel lies in
};

/// Lines through the holes of the masks: background that the figure encloses in the picture, at least 2.5 pixels from its rim.
/// @param masks  one a view, 1 channel, above 127 where the figure is; empty for a view without say; of any size of the view's shape
std::vector<SightLine> LinesThroughHoles(const std::vector<View>& views, const std::vector<Image8>& masks);

/// How many handles the lines tell from each other, each in two views at least: the rank of the linking numbers between lines that meet
/// nothing and the loops of the surface. A line links with a loop when the loop winds round its pixel.
///
/// @param closed  closed oriented 2-manifold; at most Genus(closed) are seen through
int HandlesSeenThrough(const Mesh& closed, const std::vector<SightLine>& lines);

/// Views with a hole in the mask all of whose lines the surface blocks, ascending: there it closes a window that the photograph shows.
std::vector<int> ViewsWithClosedWindow(const Mesh& surface, const std::vector<SightLine>& lines);

}  // namespace keypose::cleanup
