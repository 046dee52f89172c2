// Draws a cloud's outermost points to the outlines of the masks: fuzz, rims and soft edges that matching cuts short come back.
#pragma once

#include "core/mesh.h"
#include "reconstruct/dense_view.h"
#include "reconstruct/silhouettes.h"

namespace keypose::reconstruct {

struct SilhouetteFitOptions {
  double reach_px = 10;      ///< outlines farther than this from the cloud's own outline are not believed
  double smoothing_px = 12;  ///< over which corrections are averaged along the surface, in pixels of the views
  int rounds = 2;
};

struct SilhouetteFit {
  PointCloud cloud;
  double gap_before_px = 0;  ///< mean over outlines and views of how far inside of the mask the cloud's outline lies
  double gap_after_px = 0;
  double gap_spread_px = 0;  ///< mean absolute gap after the fit
};

/// Moves points along their normals so that the outline of the cloud in each view falls on the outline of its mask, where it is near.
///
/// In each view the outermost points along the mask's outline are found; how far they lie inside of it is a gap, which belongs to the
/// surface there, with the direction of the outline's plane. Each point then moves by the weighted median of the gaps near it whose
/// direction is near its normal, but never out of the hull. Dents stay: only points that make an outline are measured, and what lies
/// between them moves with them. Same bits for any thread count.
SilhouetteFit FitToSilhouettes(const PointCloud& cloud, const Silhouettes& silhouettes, const SilhouetteFitOptions& options);

}  // namespace keypose::reconstruct
