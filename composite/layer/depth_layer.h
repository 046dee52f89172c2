// How far the character is, at each pixel.
#pragma once

#include "core/pictures/pixel_rays.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// Where there is nothing, as Blender writes it.
inline constexpr float kNoDepth = 1e10f;

/// 1 channel: the least depth of what a pixel's rays hit of the character, along the camera's axis
/// (not along the ray), in the world's unit; kNoDepth where none does.
///
/// @param points, table, props, along  as of RenderLayer
/// Same bits for any thread count.
ImageF DepthLayer(const PointsX3& points, const FacesX3& faces, const View& view,
                  const PixelRays& rays, int along, const Ground& table,
                  const RayScene* props = nullptr);

}  // namespace keypose::composite
