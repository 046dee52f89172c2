// Detects photographs whose colours on the common surface differ from the others'.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::capture {

struct ColorOptions {
  double hue = 0.2;   ///< angle between colours [rad] that different light on one paint does not
                      ///< exceed, on a surface that is accurate to a voxel
  double spread = 3;  ///< and at least this many times the median angle of all views at the point
  /// share of differing points above which a view is an outlier
  double most_contrary = 0.4;
  int least_places = 100;  ///< with fewer points a view is not tested
};

struct ColorFit {
  int places = 0;       ///< surface points that this view and at least three others see
  double contrary = 0;  ///< share of these whose hue differs from most others' there
};

/// Compares hues, not brightness: shading moves over a figure that turns in front of a lamp.
/// @param surface  points with outward normals; `cell` is their distance
/// @param inlier   one per view: views with 0 are tested too, but the median is computed without
/// them
/// Same bits for any thread count.
std::vector<ColorFit> FitsOfColors(const std::vector<Image8>& images,
                                   const std::vector<Image8>& masks, const std::vector<View>& views,
                                   const PointCloud& surface, double cell,
                                   const std::vector<char>& inlier, const ColorOptions& options);

/// Marks views as outliers whose colours differ from the others'.
void CheckColors(const std::vector<ColorFit>& fits, const ColorOptions& options,
                 std::vector<char>& inlier);

}  // namespace keypose::capture
