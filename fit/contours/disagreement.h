// Where a mesh's silhouette and the outline of a mask are farthest apart.
#pragma once

#include <vector>

#include "fit/contours/contours.h"
#include "fit/contours/outline.h"

namespace keypose::fit {

struct Disagreement {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< on the one of the two that is beyond
  double distance_px = 0;                           ///< from there to the other
  bool mask_beyond = false;                         ///< the mask is, else the silhouette
};

/// Without what the picture's sides cut off. Nothing (distance 0) without silhouette or outline.
Disagreement WorstDisagreement(const std::vector<ContourPoint>& contour, const Outline& outline);

}  // namespace keypose::fit
