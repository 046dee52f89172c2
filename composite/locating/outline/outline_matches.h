// Distances between a mesh's outlines and a matte's, in both directions.
#pragma once

#include <vector>

#include "composite/locating/outline/matte_outline.h"
#include "composite/locating/outline/mesh_silhouette.h"

namespace keypose::composite {

/// The pixel of `position` should move along `direction` by `distance_px`.
struct OutlineMatch {
  Eigen::Vector3d position;   ///< on the mesh, in its frame
  Eigen::Vector2d pixel;      ///< where it is now
  Eigen::Vector2d direction;  ///< the matte's normal there, outwards
  double distance_px = 0;     ///< positive: the matte is larger
  double length_px = 0;       ///< of the outline that it stands for
};

struct OutlineMatches {
  std::vector<OutlineMatch> matches;  ///< from the mesh to the matte, then from the matte to it
  double unmatched_px = 0;            ///< length of outlines without partner, both together
  double length_px = 0;               ///< of all

  /// Mean distance; what has no partner counts as `reach_px`.
  double Mean(double reach_px) const;
  double MeanMatched() const;
};

/// @param reach_px  farther points are not partners
OutlineMatches MatchOutlines(const std::vector<SilhouettePoint>& silhouette,
                             const MatteOutline& outline, double reach_px);

}  // namespace keypose::composite
