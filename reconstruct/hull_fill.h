// Points of the visual hull where stereo found nothing: they let a surface close over what has no texture.
#pragma once

#include <vector>

#include "core/mesh.h"
#include "reconstruct/dense_view.h"
#include "reconstruct/depth_bounds.h"
#include "reconstruct/visual_hull.h"

namespace keypose::reconstruct {

constexpr float kHullConfidence = 0.1f;

/// Centres of surface voxels of the hull that at least two views look at, with outward normals, mean colours and kHullConfidence.
///
/// Left out where stereo knows better: within three voxels of a stereo point, and where more than a tenth of the pixels that look at
/// the place have a confirmed depth (the hull bridges a hollow there).
/// @param confirmed  for each view, 1 for each level-0 pixel with a confirmed depth
PointCloud HullFill(const VisualHull& hull, const std::vector<DenseView>& views, const std::vector<DepthBounds>& bounds,
                    const std::vector<std::vector<char>>& confirmed, const PointsX3& stereo_points);

}  // namespace keypose::reconstruct
