// Where photographs show a mesh that has too few features to match.
#pragma once

#include <vector>

#include "fit/appearance/patch_search.h"
#include "fit/bending/view_constraints.h"
#include "views/placement/surface_features.h"

namespace keypose::fit {

/// A view at one resolution: the mesh as it stands now, and the photograph.
struct PatchView {
  FitView view;
  TexturedRender render;
  const ImageF& photo;
  const GreyMask& mask;
};

/// Places of vertices in a photograph by their surroundings in a render: searched for at a low
/// resolution, found at twice that. It reaches as far as features do, and finds places between
/// them; grey values alone reach a few pixels.
///
/// @param seen    vertices that `fine` shows
/// @param points  of the mesh, as both renders have them
/// @param whole   the camera whose pixels are returned
/// @param reach   farthest that a place may be from where the mesh has it [length]
std::vector<FeatureMatch> MatchPatches(const std::vector<SeenVertex>& seen, const PointsX3& points,
                                       const PatchView& fine, const PatchView& coarse,
                                       const Pinhole& whole, double reach);

}  // namespace keypose::fit
