// What the views say about single vertices of a mesh: where they should be, and how surely.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "fit/appearance/patch_shift.h"
#include "fit/contours/outline.h"
#include "views/placement/surface_features.h"

namespace keypose::fit {

/// (x - goal)^T q (x - goal) for the point x = vertex + arm, where the arm turns with the vertex.
struct Constraint {
  int view = 0;  ///< that it comes from
  int vertex = 0;
  Eigen::Vector3d arm = Eigen::Vector3d::Zero();  ///< at rest
  Eigen::Matrix3d q = Eigen::Matrix3d::Zero();    ///< symmetric, positive semidefinite
  Eigen::Vector3d goal = Eigen::Vector3d::Zero();
};

/// A view of the mesh at the resolution in use, in the frame of the mesh.
struct FitView {
  int index = 0;
  Pinhole camera;
  Rigid3 camera_from_world;
  Eigen::Vector3d Center() const { return camera_from_world.Inverse().translation; }
};

/// Derivative of the pixel by the point, 2 x 3, times the size of a pixel at the point: of unit
/// size for directions parallel to the picture.
Eigen::Matrix<double, 2, 3> ScaledJacobian(const FitView& view, const Eigen::Vector3d& x,
                                           double* footprint);

/// Geman and McClure's weight: 1 at 0, a quarter at `scale`.
inline double RobustWeight(double distance, double scale) {
  const double s2 = scale * scale, w = s2 / (s2 + distance * distance);
  return w * w;
}

/// Pulls a point towards the ray through a pixel.
/// @param scale  distance at which the pull has a quarter of its weight [length]
Constraint PullToPixel(const FitView& view, int vertex, const Eigen::Vector3d& arm,
                       const Eigen::Vector3d& now, const Eigen::Vector2d& pixel, double weight,
                       double scale);

struct OutlineTerms {
  double weight = 1;     ///< of a constraint for an outline as long as `edge`
  double edge = 1;       ///< mean length of the mesh's edges [length]
  double scale = 0.1;    ///< distance at which a pull has a quarter of its weight [length]
  double reach_px = 50;  ///< longest distance
};

/// Constraints between the mesh's silhouette and the outline of the mask, both ways.
/// @param gap_px  if given: receives the mean absolute distance, both ways, without those beyond
///                the reach; 0 without any
std::vector<Constraint> OutlineConstraints(const PointsX3& points,
                                           const std::vector<ContourPoint>& contour,
                                           const Outline& outline, const FitView& view,
                                           const OutlineTerms& terms, double* gap_px = nullptr);

/// Constraints of patches that were found shifted.
/// @param areas   of the vertices, over the whole area
std::vector<Constraint> AppearanceConstraints(const PointsX3& points,
                                              const std::vector<SeenVertex>& seen,
                                              const std::vector<PatchShift>& shifts,
                                              const Eigen::VectorXd& areas, const FitView& view,
                                              double weight, double scale_px);

}  // namespace keypose::fit
