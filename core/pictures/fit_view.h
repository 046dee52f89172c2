// Cameras that look at something, and the part of their picture that it covers.
#pragma once

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose {

/// The pose, camera from world, of a camera (z forward, y down) at `eye` that looks at `target`,
/// with `up` pointing upwards in the picture.
/// @throws InputError  eye and target coincide
Rigid3 LookAt(const Eigen::Vector3d& eye, const Eigen::Vector3d& target,
              const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ());

/// A view that shows all points with a small margin.
///
/// @param azimuth_deg    0 looks along +y (from the front, -y), 90 sees the +x side;
/// counter-clockwise seen from above
/// @param elevation_deg  height of the eye above the horizon, in (-90, 90)
/// @param fov_deg        vertical field of view
/// @throws InputError  no points, or a size below one pixel
View FitView(const PointsX3& points, double azimuth_deg, double elevation_deg, int width,
             int height, const Eigen::Vector3d& up = Eigen::Vector3d::UnitZ(), double fov_deg = 28);

/// Pixels [x0,x1) x [y0,y1) within the image.
struct PixelBox {
  int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
  bool empty() const { return x0 >= x1 || y0 >= y1; }
};
/// The pixels that the mesh's faces can cover, and a few more because of distortion. The whole
/// image when a vertex is beside or behind the camera.
PixelBox ProjectedBounds(const PointsX3& points, const View& view);

}  // namespace keypose
