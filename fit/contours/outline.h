// The outline of a mask, and the distances between it and a mesh's silhouette, in both directions.
#pragma once

#include <vector>

#include "fit/contours/contours.h"
#include "views/hull/mask_field.h"

namespace keypose::fit {

/// The outline of one view's mask at one level of its pyramid.
struct Outline {
  struct Point {
    Eigen::Vector2d pixel;   ///< on the outline, to a fraction of a pixel
    Eigen::Vector2d normal;  ///< unit, outwards
  };
  MaskField field;
  std::vector<Point> points;  ///< about one every second pixel; none at the picture's sides

  /// Signed distance [px], positive outside; beyond the picture it grows with the way to it.
  double Distance(const Eigen::Vector2d& pixel) const;
  /// Its gradient, of unit length or zero.
  Eigen::Vector2d Gradient(const Eigen::Vector2d& pixel) const;
  /// Whether the mask may continue beyond the picture next to this pixel.
  bool Cut(const Eigen::Vector2d& pixel) const;
};
Outline MakeOutline(const PreparedView& view, int level);

/// One constraint: the contour point should move along `direction` by `distance_px`.
struct OutlineMatch {
  int contour = 0;            ///< index of the contour point
  Eigen::Vector2d direction;  ///< unit, in the picture
  double distance_px = 0;     ///< signed
  double length_px = 0;       ///< of the outline that the constraint stands for
};

/// From the silhouette to the outline: the signed distance at each point. Points whose normal
/// differs from the outline's by more than 60 degrees are left out.
std::vector<OutlineMatch> MatchToOutline(const std::vector<ContourPoint>& contour,
                                         const Outline& outline, double reach_px);
/// From the outline to the silhouette: for each outline point the nearest contour point with a
/// similar normal. This pulls out what the silhouette has shrunk, such as a limb's end.
std::vector<OutlineMatch> MatchFromOutline(const std::vector<ContourPoint>& contour,
                                           const Outline& outline, double reach_px);

}  // namespace keypose::fit
