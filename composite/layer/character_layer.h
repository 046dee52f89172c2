// The character alone, as a camera sees it.
#pragma once

#include <memory>
#include <vector>

#include "core/pictures/pixel_rays.h"
#include "core/pictures/render.h"
#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/film/ground_shadow.h"

namespace keypose::composite {

/// What does not change from frame to frame.
struct Character {
  FacesX3 faces;
  UvsX2 uvs;         ///< in [0,1], v up
  FacesX3 uv_faces;  ///< F x 3
  ImageF texture;    ///< RGB, linear light
};

/// RGBA in linear light, premultiplied: alpha is the share of the pixel that the character covers.
/// Rays spread over each pixel's area; soft edges come from them alone.
///
/// @param points  V x 3 in world
/// @param gains   V x 3, factors on the texture's light; empty: all 1
/// @param table   what lies below it is hidden by it, seen from above; null: nothing is hidden
/// @param props   of the set: what they hide of it does not cover; null: none
/// @param along   rays along each side of a pixel, at least 1
/// Same bits for any thread count.
ImageF RenderLayer(const Character& character, const PointsX3& points, const RayScene& scene,
                   const PointsX3& gains, const View& view, const PixelRays& rays, int along,
                   const Ground* table = nullptr, const RayScene* props = nullptr);

}  // namespace keypose::composite
