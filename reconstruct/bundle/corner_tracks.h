// New points for a model that has few: grey-value corners at places without points.
#pragma once

#include <vector>

#include "reconstruct/bundle/patch_tracks.h"

namespace keypose::reconstruct {

struct CornerOptions {
  int cell_px = 10;      ///< at most one corner per square of this side, at the size of PatchImages
  int neighbors = 6;     ///< known points around a corner from which its depth is interpolated
  double reach_px = 70;  ///< largest distance of these
  double most_bent = 0.02;  ///< largest distance of these from a plane, over the depth
  int most_points = 6000;   ///< in all, including the scene's
};

/// The scene with more points. The depth of a corner is that of the plane through the known points
/// around it in the same view; TrackPatches then tests whether other views agree, and finds the
/// exact position.
///
/// @param scene   points' views are those in which the point is not occluded
/// @param images  by view, made with masks: corners are at least half a patch's side from the
/// mask's border
/// Same bits for any thread count.
/// Source of the measure: Shi & Tomasi, "Good features to track", CVPR 1994.
Scene AddCorners(const Scene& scene, const std::vector<PatchImage>& images,
                 const PatchOptions& patches, const CornerOptions& options);

}  // namespace keypose::reconstruct
