// Which photographs show other colours on the common space's surface than the others do.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::capture {

struct ColorOptions {
  double hue = 0.2;   ///< angle between colours that one paint does not reach on a surface known to
                      ///< a voxel [rad]
  double spread = 3;  ///< and so many times the median angle of all views at the place
  /// share of contrary places, from which on a view shows something else
  double most_contrary = 0.4;
  int least_places = 100;  ///< with fewer nothing is said of a view
};

struct ColorFit {
  int places = 0;       ///< of the surface, that it and three others show
  double contrary = 0;  ///< share of these whose hue is not what most others show there
};

/// Hues, not brightness: shading moves over a figure that turns before a lamp.
/// @param surface  points with outward normals; `cell` is their distance
/// @param inlier   one a view: those with 0 are judged too, but the median is taken without them
/// Same bits for any thread count.
std::vector<ColorFit> FitsOfColors(const std::vector<Image8>& images,
                                   const std::vector<Image8>& masks, const std::vector<View>& views,
                                   const PointCloud& surface, double cell,
                                   const std::vector<char>& inlier, const ColorOptions& options);

/// Makes outliers of views that contradict the others in colour.
void JudgeColors(const std::vector<ColorFit>& fits, const ColorOptions& options,
                 std::vector<char>& inlier);

}  // namespace keypose::capture
