// Projection of a point by a camera, with the derivatives that bundle adjustments need.
#pragma once

#include <Eigen/Geometry>

namespace keypose::reconstruct {

/// Pixel of a point in the camera's frame; the distortion is Brown's, as in core/values/camera.h.
///
/// @param camera    fx fy cx cy k1 k2 p1 p2
/// @param of_camera derivative with respect to those, if not null
/// @param of_point  derivative with respect to the point, if not null
inline Eigen::Vector2d ProjectPoint(const double* camera, const Eigen::Vector3d& x,
                                    Eigen::Matrix<double, 2, 8>* of_camera,
                                    Eigen::Matrix<double, 2, 3>* of_point) {
  const double u = x.x() / x.z(), v = x.y() / x.z(), r2 = u * u + v * v;
  const double k1 = camera[4], k2 = camera[5], p1 = camera[6], p2 = camera[7],
               radial = 1 + r2 * (k1 + r2 * k2);
  const double du = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u),
               dv = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v);
  if (of_camera)
    *of_camera << du, 0, 1, 0, camera[0] * u * r2, camera[0] * u * r2 * r2, camera[0] * 2 * u * v,
        camera[0] * (r2 + 2 * u * u),  //
        0, dv, 0, 1, camera[1] * v * r2, camera[1] * v * r2 * r2, camera[1] * (r2 + 2 * v * v),
        camera[1] * 2 * u * v;
  if (of_point) {
    const double slope = 2 * (k1 + 2 * r2 * k2);  // d radial / du = slope u
    Eigen::Matrix2d of_ray;
    of_ray(0, 0) = camera[0] * (radial + u * u * slope + 2 * p1 * v + 6 * p2 * u);
    of_ray(0, 1) = camera[0] * (u * v * slope + 2 * p1 * u + 2 * p2 * v);
    of_ray(1, 0) = camera[1] * (u * v * slope + 2 * p2 * v + 2 * p1 * u);
    of_ray(1, 1) = camera[1] * (radial + v * v * slope + 2 * p2 * u + 6 * p1 * v);
    Eigen::Matrix<double, 2, 3> ray_of_point;
    ray_of_point << 1 / x.z(), 0, -u / x.z(), 0, 1 / x.z(), -v / x.z();
    *of_point = of_ray * ray_of_point;
  }
  return {camera[0] * du + camera[2], camera[1] * dv + camera[3]};
}

/// Derivative of q * x with respect to the coefficients (x, y, z, w) of a unit q, where q * x = x +
/// 2 w (v x x) + 2 v x (v x x).
inline Eigen::Matrix<double, 3, 4> RotatedByQuaternion(const Eigen::Quaterniond& q,
                                                       const Eigen::Vector3d& x) {
  const Eigen::Vector3d v = q.vec();
  Eigen::Matrix3d cross;
  cross << 0, -x.z(), x.y(), x.z(), 0, -x.x(), -x.y(), x.x(), 0;
  Eigen::Matrix<double, 3, 4> j;
  j.leftCols<3>() = 2 * (v.dot(x) * Eigen::Matrix3d::Identity() + v * x.transpose() -
                         2 * x * v.transpose() - q.w() * cross);
  j.col(3) = 2 * v.cross(x);
  return j;
}

/// `values` of a Ceres Jacobian as a 2 x C matrix.
template <int kColumns>
Eigen::Map<Eigen::Matrix<double, 2, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>
JacobianRows(double* values) {
  return Eigen::Map<
      Eigen::Matrix<double, 2, kColumns, kColumns == 1 ? Eigen::ColMajor : Eigen::RowMajor>>(
      values);
}

}  // namespace keypose::reconstruct
