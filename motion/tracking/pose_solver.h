// Gauss-Newton on the 38 numbers of one pose.
#pragma once

#include <vector>

#include "motion/tracking/outline_residuals.h"
#include "motion/tracking/pose_prior.h"

namespace keypose::motion {

struct PoseOptions {
  int rounds = 5;                        ///< of new contours and matches
  int steps = 2;                         ///< of Gauss-Newton in each round
  double reach = OutlineTuning::kReach;  ///< [px] of the robust loss in the last round
  double first_reach = 0;  ///< [px] in the first round; 0: `reach`. It falls in between.
  std::vector<QuadraticPrior> priors;  ///< in the chart of the start
};

struct PoseFit {
  BodyPose pose;
  PoseSystem data;         ///< of the silhouettes alone at `pose`, in pixels^2
  double measured = 0;     ///< sum of stands_for: independent measurements
  double cost = 0;         ///< robust cost of the silhouettes per measurement [px^2]
  double unexplained = 0;  ///< share of the outlines without a part of the template near them
};

/// The system of the silhouettes' residuals at a pose, robust weights included.
/// Same bits for any thread count.
PoseSystem OutlineSystem(const std::vector<Silhouette>& silhouettes,
                         const std::vector<ViewMatches>& matches, const PosedBody& body,
                         double reach, double* measured = nullptr);

/// Contours and matches in all views.
std::vector<ViewMatches> FindAllMatches(const std::vector<Silhouette>& silhouettes,
                                        const LocalSurface& surface, const PosedBody& body,
                                        double reach);

/// The pose near `start` whose silhouettes agree best with the views'.
///
/// @param surface  SurfaceOf(shape)
/// Cost: rounds x views x (a drawing of the template, and as many distances as samples times
/// outline points).
/// Same bits for any thread count.
PoseFit SolvePose(const std::vector<Silhouette>& silhouettes, const BodyShape& shape,
                  const LocalSurface& surface, const BodyPose& start, const PoseOptions& options);

/// Standard deviations of the 38 numbers: the inverse of the silhouettes' system, scaled by their
/// residuals, with each joint known at least to its range. A number that no outline depends on,
/// such as the twist of a straight, round limb, gets about its range.
DofVector StandardDeviations(const PoseFit& fit);

}  // namespace keypose::motion
