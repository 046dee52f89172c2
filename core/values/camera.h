// Pinhole cameras with Brown distortion, rigid motions, similarities, and a reconstructed scene of
// views and sparse points.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// x_in_b = rotation * x_in_a + translation.
struct Rigid3 {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const { return rotation * x + translation; }
  Rigid3 Inverse() const { return {rotation.conjugate(), -(rotation.conjugate() * translation)}; }
};
Rigid3 Compose(const Rigid3& c_from_b, const Rigid3& b_from_a);

/// x_in_b = scale * rotation * x_in_a + translation.
struct Similarity3 {
  double scale = 1;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  Eigen::Vector3d operator*(const Eigen::Vector3d& x) const {
    return scale * (rotation * x) + translation;
  }
  Similarity3 Inverse() const;
};
PointsX3 Transformed(const Similarity3& b_from_a, const PointsX3& points_in_a);

/// The similarity (or rigid motion) that maps the rows of `a` to the rows of `b` with the least
/// weighted sum of squared errors. It never mirrors (det > 0).
///
/// @param a, b     P x 3, P >= 3
/// @param weights  P; empty: all 1
/// @throws InputError  fewer than 3 pairs, all weights are zero, or all points of `a` coincide
/// Source: Umeyama, TPAMI 1991.
Similarity3 FitSimilarity(const PointsX3& a, const PointsX3& b, const Eigen::VectorXd& weights = {},
                          bool with_scale = true);

/// Intrinsics in pixels. Pixel centres lie at .5 (COLMAP's convention). The distortion is that of
/// OpenCV and of COLMAP's OPENCV model.
struct Camera {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0;

  bool distorted() const { return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0; }
  /// The pixel of a point in the camera's frame (z forward, y down). Not meaningful for z <= 0.
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_camera) const;
  /// The point with z = 1 in the camera's frame that projects to `pixel`. Inverts the distortion by
  /// fixed-point iteration.
  Eigen::Vector3d Unproject(const Eigen::Vector2d& pixel) const;
  /// The same camera for an image scaled by `factor` in both directions. The distortion stays.
  Camera Scaled(double factor) const;
  Eigen::Matrix3d K() const;
};

struct View {
  std::string name;  ///< file name relative to the image folder
  Camera camera;
  Rigid3 camera_from_world;
  Eigen::Vector3d Center() const { return camera_from_world.Inverse().translation; }
  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_world) const {
    return camera.Project(camera_from_world * x_in_world);
  }
};

struct SparsePoint {
  Eigen::Vector3d position;  ///< in world
  Eigen::Matrix<std::uint8_t, 3, 1> color;
  double error_px = 0;
  std::vector<int> views;  ///< indices into Scene::views, ascending, unique
};

/// The result of structure from motion.
struct Scene {
  std::vector<View> views;  ///< sorted by name
  std::vector<SparsePoint> points;
};

/// The scene in another frame. Reprojection errors and tracks stay.
Scene Transformed(const Similarity3& b_from_a, const Scene& scene_in_a);

}  // namespace keypose
