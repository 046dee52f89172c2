// New points for a model that has few: corners of the pictures' grey values where no point is yet.
#pragma once

#include <vector>

#include "reconstruct/bundle/patch_tracks.h"

namespace keypose::reconstruct {

struct CornerOptions {
  int cell_px = 10;   ///< one corner in a square of this side at most, at the size of PatchImages
  int neighbors = 6;  ///< known points round a corner that its depth is taken from
  double reach_px = 70;     ///< how far off these may be
  double most_bent = 0.02;  ///< by how much of the depth they may lie off a plane
  int most_points = 6000;   ///< in all, those that the scene has included
};

/// The scene with more points. A corner's depth is that of the plane through the known points round
/// it in the same view; TrackPatches then finds out whether other views agree, and where exactly.
///
/// @param scene   points' views are those in which the point is not hidden
/// @param images  by view, made with masks: corners keep half a patch's side from the mask's rim
/// Same bits for any thread count. Source of the measure: Shi & Tomasi, "Good features to track",
/// CVPR 1994.
Scene AddCorners(const Scene& scene, const std::vector<PatchImage>& images,
                 const PatchOptions& patches, const CornerOptions& options);

}  // namespace keypose::reconstruct
