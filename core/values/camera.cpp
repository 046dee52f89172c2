#include "core/values/camera.h"

#include <Eigen/SVD>
#include <cmath>

#include "core/values/errors.h"

namespace keypose {

Rigid3 Compose(const Rigid3& c_from_b, const Rigid3& b_from_a) {
  return {(c_from_b.rotation * b_from_a.rotation).normalized(),
          c_from_b.rotation * b_from_a.translation + c_from_b.translation};
}

Similarity3 Similarity3::Inverse() const {
  Similarity3 inverse;
  inverse.scale = 1 / scale;
  inverse.rotation = rotation.transpose();
  inverse.translation = -(inverse.scale * (inverse.rotation * translation));
  return inverse;
}

PointsX3 Transformed(const Similarity3& b_from_a, const PointsX3& points_in_a) {
  PointsX3 points_in_b = b_from_a.scale * (points_in_a * b_from_a.rotation.transpose());
  points_in_b.rowwise() += b_from_a.translation.transpose();
  return points_in_b;
}

Similarity3 FitSimilarity(const PointsX3& a, const PointsX3& b, const Eigen::VectorXd& weights,
                          bool with_scale) {
  if (a.rows() != b.rows() || a.rows() < 3)
    throw InputError("fitting a similarity needs at least 3 pairs of points, but there are " +
                     std::to_string(std::min(a.rows(), b.rows())));
  const Eigen::VectorXd w = weights.size() == a.rows() ? weights : Eigen::VectorXd::Ones(a.rows());
  const double total = w.sum();
  if (!(total > 0)) throw InputError("fitting a similarity: all weights are zero");
  const Eigen::RowVector3d mean_a = (w.transpose() * a) / total;
  const Eigen::RowVector3d mean_b = (w.transpose() * b) / total;
  const PointsX3 da = a.rowwise() - mean_a, db = b.rowwise() - mean_b;
  const double variance_a = (da.rowwise().squaredNorm().array() * w.array()).sum() / total;
  if (!(variance_a > 0)) throw InputError("fitting a similarity: all points coincide");
  const Eigen::Matrix3d covariance = db.transpose() * w.asDiagonal() * da / total;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(covariance,
                                              Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Vector3d sign(1, 1, 1);
  if (svd.matrixU().determinant() * svd.matrixV().determinant() < 0) sign(2) = -1;
  Similarity3 fit;
  fit.rotation = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  fit.scale = with_scale ? svd.singularValues().dot(sign) / variance_a : 1.0;
  fit.translation = mean_b.transpose() - fit.scale * (fit.rotation * mean_a.transpose());
  return fit;
}

Eigen::Vector2d Camera::Project(const Eigen::Vector3d& x_in_camera) const {
  const double u = x_in_camera.x() / x_in_camera.z(), v = x_in_camera.y() / x_in_camera.z();
  const double r2 = u * u + v * v;
  const double radial = 1 + r2 * (k1 + r2 * k2);
  const double ud = u * radial + 2 * p1 * u * v + p2 * (r2 + 2 * u * u);
  const double vd = v * radial + 2 * p2 * u * v + p1 * (r2 + 2 * v * v);
  return {fx * ud + cx, fy * vd + cy};
}

Eigen::Vector3d Camera::Unproject(const Eigen::Vector2d& pixel) const {
  const double ud = (pixel.x() - cx) / fx, vd = (pixel.y() - cy) / fy;
  double u = ud, v = vd;
  if (distorted()) {
    for (int i = 0; i < 20; ++i) {
      const double r2 = u * u + v * v;
      const double radial = 1 + r2 * (k1 + r2 * k2);
      const double next_u = (ud - 2 * p1 * u * v - p2 * (r2 + 2 * u * u)) / radial;
      const double next_v = (vd - 2 * p2 * u * v - p1 * (r2 + 2 * v * v)) / radial;
      const double change = std::abs(next_u - u) + std::abs(next_v - v);
      u = next_u;
      v = next_v;
      if (change < 1e-14) break;
    }
  }
  return {u, v, 1};
}

Camera Camera::Scaled(double factor) const {
  Camera scaled = *this;
  scaled.width = static_cast<int>(std::lround(width * factor));
  scaled.height = static_cast<int>(std::lround(height * factor));
  const double sx = static_cast<double>(scaled.width) / width,
               sy = static_cast<double>(scaled.height) / height;
  scaled.fx *= sx;
  scaled.cx *= sx;
  scaled.fy *= sy;
  scaled.cy *= sy;
  return scaled;
}

Eigen::Matrix3d Camera::K() const {
  Eigen::Matrix3d k;
  k << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return k;
}

Scene Transformed(const Similarity3& b_from_a, const Scene& scene_in_a) {
  Scene scene = scene_in_a;
  const Eigen::Quaterniond rotation(b_from_a.rotation);
  for (View& view : scene.views) {
    Rigid3& pose = view.camera_from_world;
    const Eigen::Vector3d center = b_from_a * view.Center();
    pose.rotation = (pose.rotation * rotation.conjugate()).normalized();
    pose.translation = -(pose.rotation * center);
  }
  for (SparsePoint& point : scene.points) point.position = b_from_a * point.position;
  return scene;
}

}  // namespace keypose
