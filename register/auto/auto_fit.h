// One level of detail being bent: by landmarks, by matches, by the surface.
#pragma once

#include "deform/levels/levels.h"
#include "register/auto/surface_pull.h"

namespace keypose::registration {

/// What pulls how hard in one round. Lengths are for a target of diagonal 2.
struct FitTerms {
  double stiffness = 1;   ///< of the shape against the surface
  double robust = 0.4;    ///< distance at which a surface pull counts a quarter
  double landmarks = 50;  ///< weight of each
  double matches = 0;     ///< weight of all together
  int samples = 1500;     ///< of the target, that pull back
  int turns = 2;          ///< of maps and positions for one search of closest points
  bool measure = true;    ///< whether the gap is asked for
};

/// Landmarks alone, until nothing moves by more than 1e-4 of the diagonal.
void FitToLandmarks(Level& level, double weight);
/// Landmarks and matches; matches are believed less the further they lie from where the others
/// agree.
void FitToMatches(Level& level, const PointsX3& match_points, double landmark_weight);
/// One search of closest points and the rounds that follow from it. `seen`, when asked for: 0 to 1,
/// how firmly the surface holds each vertex.
SurfaceGap FitToSurface(Level& level, const SurfacePull& target, const PointsX3& match_points,
                        const FitTerms& terms, Eigen::VectorXd* seen = nullptr);

}  // namespace keypose::registration
