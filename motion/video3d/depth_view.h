// Which part of a mesh a camera sees: a depth buffer of its triangles.
#pragma once

#include "core/pictures/render.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::motion {

/// Inverse depth of the nearest surface at the centre of each pixel of a box.
struct DepthView {
  PixelBox box;    ///< the part of the picture that is stored; empty: the mesh is not seen
  ImageF inverse;  ///< 1 / z in the camera's frame; 0: no surface

  float At(int x, int y) const { return *inverse.at(x - box.x0, y - box.y0); }
};

/// Triangles are drawn straight between their projected corners, so that distortion within a
/// triangle is neglected; triangles with a corner beside or behind the camera are left out.
/// @param points  V x 3, in world
DepthView MakeDepthView(const PointsX3& points, const FacesX3& faces, const View& view);

}  // namespace keypose::motion
