// A picture of a point cloud, for reports and for whoever waits for the surface.
#pragma once

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose {

/// Each point as a square of two pixels, the nearest in front, on near white; grey where the cloud
/// has no colours.
/// Same bits for any thread count.
///
/// @param view  its camera says the picture's size; FitView of render.h makes one that holds all
/// points
/// @return RGB
Image8 RenderCloud(const PointCloud& cloud, const View& view);

/// The cloud from four sides, 90 degrees apart, in one row. RGB, 4 x `width` wide.
/// @throws InputError  no points
Image8 RenderCloudSides(const PointCloud& cloud, int width, int height);

}  // namespace keypose
