// The animation as a text file of Universal Scene Description.
#pragma once

#include "core/values/progress.h"
#include "export/animation/scene.h"

namespace keypose::exporting {

/// `NAME.usda` beside the folder `textures/`, whose first texture it shows: a mesh with the frames'
/// vertices, not split, whose points, normals and extent have time samples; texture coordinates per
/// corner; a UsdPreviewSurface. +y up, one unit of the frames is one metre. The time codes are
/// frames at the scene's frame rate: one sample per keyframe of SceneKeyframes, so that linear
/// interpolation, USD's default, holds and steps where players should. The values outside of the
/// samples are those of the first keyframe, for readers that do not animate.
///
/// @return `error_over_diagonal` of the points, which are in single precision; measured:
/// `time_samples`
/// Source: OpenUSD 23.11, "USDA file format", UsdGeom and UsdPreviewSurface specification 2.6.
FormatFiles MakeUsda(const Scene& scene, Progress* progress);

/// A name as USD allows it for prims before version 24.03: a letter or underscore, then letters,
/// digits and underscores. Each other byte becomes an underscore.
std::string PrimName(const std::string& name);

}  // namespace keypose::exporting
