// Points of the visual hull where stereo found nothing, so that the surface closes over areas
// without texture.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "views/hull/depth_bounds.h"
#include "views/hull/silhouettes.h"
#include "views/hull/visual_hull.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

constexpr float kHullConfidence = 0.1f;

/// Points of the hull's surface that at least two views see, with outward normals, mean colours and
/// kHullConfidence.
///
/// Left out where stereo is more accurate: within three voxels of a stereo point of confidence 0.3
/// or more, and where more than a tenth of the pixels that see the point have a confirmed depth
/// (the hull spans a concavity there). On the underside that no camera faces, a band of 13 voxels
/// along such stereo points is added, so that the surface turns inwards where the outlines end.
/// @param hull       carved with a margin from the views of `silhouettes`
/// @param confirmed  for each view, 1 for each level-0 pixel with a confirmed depth
/// @param stereo     with confidence
PointCloud HullFill(const VisualHull& hull, const Silhouettes& silhouettes,
                    const std::vector<PreparedView>& views, const std::vector<DepthBounds>& bounds,
                    const std::vector<std::vector<char>>& confirmed, const PointCloud& stereo);

}  // namespace keypose::reconstruct
