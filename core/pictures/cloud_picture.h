// Pictures of a point cloud, for reports and as a preview before the surface is ready.
#pragma once

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

/// Draws each point as a square of 2 x 2 pixels, the nearest in front, on a nearly white
/// background. Points are grey when the cloud has no colours.
/// Same bits for any thread count.
///
/// @param view  its camera gives the size of the picture; FitView of render.h makes a view that
/// shows all points
/// @return RGB
Image8 RenderCloud(const PointCloud& cloud, const View& view);

/// The cloud from four sides, 90 degrees apart, in one row. RGB, 4 x `width` wide.
/// @throws InputError  no points
Image8 RenderCloudSides(const PointCloud& cloud, int width, int height);

}  // namespace keypose
