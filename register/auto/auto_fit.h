// Bends one level of detail: with landmarks, with matches, and with the target surface.
#pragma once

#include "deform/levels/levels.h"
#include "register/auto/surface_pull.h"

namespace keypose::registration {

/// The weights of one round. Lengths assume a target whose diagonal is 2.
struct FitTerms {
  double stiffness = 1;   ///< of the shape term, relative to the surface
  double robust = 0.4;    ///< distance at which a surface pull has a quarter of its weight [length]
  double landmarks = 50;  ///< weight of each landmark
  double matches = 0;     ///< weight of all matches together
  int samples = 1500;     ///< target vertices that pull back
  int turns = 2;          ///< updates of positions and maps for each search of closest points
  bool measure = true;    ///< whether to compute the gap
};

/// Fits the level to its landmarks alone. Stops when no vertex moves by more than 1e-4 of the
/// diagonal, or after 500 updates.
void FitToLandmarks(Level& level, double weight);
/// Fits the level to landmarks and matches. A match far from the current position of its vertex has
/// a low weight.
/// @param match_points  the points that level.matches index
void FitToMatches(Level& level, const PointsX3& match_points, double landmark_weight);
/// Searches closest points once, then updates positions and maps terms.turns times.
/// @param match_points  the points that level.matches index
/// @param seen          if given: V, 0 to 1, how firmly the surface holds each vertex
/// @return the gap before the update; its distances are 0 without terms.measure
SurfaceGap FitToSurface(Level& level, const SurfacePull& target, const PointsX3& match_points,
                        const FitTerms& terms, Eigen::VectorXd* seen = nullptr);

}  // namespace keypose::registration
