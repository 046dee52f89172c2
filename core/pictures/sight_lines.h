// Lines of sight through the holes of masks, where photographs show background through the figure.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

/// The ray of a pixel that shows background inside of the figure's outline.
struct SightLine {
  Eigen::Vector3d origin;     ///< the camera's centre, in the surface's frame
  Eigen::Vector3d direction;  ///< any length
  int view = 0;
  int hole = 0;  ///< the hole of the mask that the pixel lies in, numbered over all views
};

/// Rays through the holes of the masks. A hole is background that the figure encloses in the
/// picture. Only pixels at least 2.5 pixels from the figure are used, about 64 for each hole.
/// @param masks  one for each view: 1 channel, above 127 where the figure is, of any size with the
/// view's aspect ratio; empty: the view is ignored
std::vector<SightLine> LinesThroughHoles(const std::vector<View>& views,
                                         const std::vector<Image8>& masks);

/// The holes for which the surface blocks every line, ascending.
std::vector<int> ClosedHoles(const Mesh& surface, const std::vector<SightLine>& lines);

/// The views of these holes, ascending. In them the surface closes a window that the photograph
/// shows.
std::vector<int> ViewsWithClosedWindow(const Mesh& surface, const std::vector<SightLine>& lines);

}  // namespace keypose
