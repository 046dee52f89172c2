// Features matched between a photograph and a render of the mesh near its true pose.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "fit/appearance/textured_render.h"
#include "fit/bending/view_constraints.h"
#include "views/placement/surface_features.h"

namespace keypose::fit {

/// Matches within `reach_px` of where the mesh shows the same place now. Nearness replaces most of
/// the comparison with other places, so many more features match than by appearance alone, and
/// they are seen from the photograph's own side.
///
/// @param render  of the mesh in this view, without distortion, of level 0
/// @param photo   features of the photograph at level 0
std::vector<FeatureMatch> MatchNearby(const FacesX3& faces, const RayScene& scene,
                                      const TexturedRender& render, const FitView& view,
                                      const PictureFeatures& photo, double reach_px);

}  // namespace keypose::fit
