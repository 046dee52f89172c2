#include "core/pictures/fit_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/values/errors.h"

namespace keypose {

using Eigen::Vector2d;
using Eigen::Vector3d;

Rigid3 LookAt(const Vector3d& eye, const Vector3d& target, const Vector3d& up) {
  const Vector3d forward = target - eye;
  if (!(forward.norm() > 0))
    throw InputError(
        "render: the camera's position is the point that it should look at; move one of them");
  const Vector3d z = forward.normalized();
  Vector3d x = z.cross(up);
  if (x.norm() < 1e-9 * up.norm()) x = z.unitOrthogonal();
  x.normalize();
  Eigen::Matrix3d camera_from_world;
  camera_from_world << x.transpose(), z.cross(x).transpose(), z.transpose();
  Rigid3 result;
  result.rotation = Eigen::Quaterniond(camera_from_world).normalized();
  result.translation = -(result.rotation * eye);
  return result;
}

View FitView(const PointsX3& points, double azimuth_deg, double elevation_deg, int width,
             int height, const Vector3d& up, double fov_deg) {
  if (points.rows() == 0) throw InputError("render: nothing to look at: the mesh has no vertices");
  if (width < 1 || height < 1)
    throw InputError("render: a picture needs at least one pixel each way");
  const Vector3d z = up.normalized();
  // With z up, the front is -y. For another up axis, any fixed horizontal direction is used.
  Vector3d right = std::abs(z.x()) < 0.9 ? Vector3d::UnitX() : Vector3d::UnitY();
  right = (right - right.dot(z) * z).normalized();
  const Vector3d front = right.cross(z);
  const double a = azimuth_deg * M_PI / 180, e = elevation_deg * M_PI / 180;
  const Vector3d outward =
      std::cos(e) * (std::cos(a) * front + std::sin(a) * right) + std::sin(e) * z;
  const Vector3d center =
      0.5 * (points.colwise().minCoeff() + points.colwise().maxCoeff()).transpose();
  View view;
  view.camera.width = width;
  view.camera.height = height;
  view.camera.fx = view.camera.fy = 0.5 * height / std::tan(fov_deg * M_PI / 360);
  view.camera.cx = 0.5 * width;
  view.camera.cy = 0.5 * height;
  const Rigid3 turned = LookAt(center + outward, center, z);
  const Eigen::Matrix3d rotation = turned.rotation.toRotationMatrix();
  const double slope_x = 0.94 * 0.5 * width / view.camera.fx,
               slope_y = 0.94 * 0.5 * height / view.camera.fy;
  double distance = 0;
  for (int v = 0; v < points.rows(); ++v) {
    const Vector3d x = rotation * (points.row(v).transpose() - center);
    distance =
        std::max({distance, std::abs(x.x()) / slope_x - x.z(), std::abs(x.y()) / slope_y - x.z()});
  }
  if (!(distance > 0)) distance = 1;
  view.camera_from_world = LookAt(center + distance * outward, center, z);
  return view;
}

PixelBox ProjectedBounds(const PointsX3& points, const View& view) {
  const Camera& c = view.camera;
  const PixelBox all{0, 0, c.width, c.height};
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
  const Eigen::Matrix3d rotation = view.camera_from_world.rotation.toRotationMatrix();
  for (int v = 0; v < points.rows(); ++v) {
    const Vector3d x = rotation * points.row(v).transpose() + view.camera_from_world.translation;
    // The projection of a vertex beside or behind the camera does not bound its faces. Neither does
    // one with strong distortion far from the axis.
    if (x.z() <= 1e-3 * x.norm()) return all;
    const Vector2d p = c.Project(x);
    low = low.cwiseMin(p);
    high = high.cwiseMax(p);
  }
  // Distortion bends lines, so a face may reach a little beyond its corners.
  const double margin = 2 + (c.distorted() ? 0.02 * (high - low).norm() : 0);
  const auto clamp = [](double x, int most) {
    return static_cast<int>(std::clamp(x, 0.0, static_cast<double>(most)));
  };
  return {
      clamp(std::floor(low.x() - margin), c.width), clamp(std::floor(low.y() - margin), c.height),
      clamp(std::ceil(high.x() + margin), c.width), clamp(std::ceil(high.y() + margin), c.height)};
}

}  // namespace keypose
