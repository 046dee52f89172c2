#include "fit/bending/view_constraints.h"

#include <cmath>

#include "core/values/size_of.h"

namespace keypose::fit {

Eigen::Matrix<double, 2, 3> ScaledJacobian(const FitView& view, const Eigen::Vector3d& x,
                                           double* footprint) {
  const Eigen::Vector3d c = view.camera_from_world * x;
  *footprint = c.z() / view.camera.fx;
  Eigen::Matrix<double, 2, 3> j;
  j << 1, 0, -c.x() / c.z(), 0, view.camera.fy / view.camera.fx,
      -view.camera.fy / view.camera.fx * c.y() / c.z();
  return j * view.camera_from_world.rotation.toRotationMatrix();
}

Constraint PullToPixel(const FitView& view, int vertex, const Eigen::Vector3d& arm,
                       const Eigen::Vector3d& now, const Eigen::Vector2d& pixel, double weight,
                       double scale) {
  const Eigen::Vector3d eye = view.Center();
  const Eigen::Vector3d ray =
      (view.camera_from_world.rotation.conjugate() * view.camera.Ray(pixel.x(), pixel.y()))
          .normalized();
  const Eigen::Vector3d foot = eye + ray * ray.dot(now - eye);
  const double w = weight * RobustWeight((now - foot).norm(), scale);
  return {view.index, vertex, arm, w * (Eigen::Matrix3d::Identity() - ray * ray.transpose()), foot};
}

namespace {

/// Two constraints, one for each end of the contour point's edge.
void AddContourPull(const PointsX3& points, const ContourPoint& at, const OutlineMatch& match,
                    const FitView& view, const OutlineTerms& terms,
                    std::vector<Constraint>& constraints) {
  for (const int v : {at.a, at.b}) {
    const Eigen::Vector3d x = points.row(v);
    double footprint = 0;
    const Eigen::Vector3d normal =
        (ScaledJacobian(view, x, &footprint).transpose() * match.direction).normalized();
    const double distance = match.distance_px * footprint;
    const double share = 0.5 * match.length_px * footprint / terms.edge;
    const double w = terms.weight * share * RobustWeight(distance, terms.scale);
    constraints.push_back({view.index, v, Eigen::Vector3d::Zero(), w * normal * normal.transpose(),
                           x + distance * normal});
  }
}

}  // namespace

std::vector<Constraint> OutlineConstraints(const PointsX3& points,
                                           const std::vector<ContourPoint>& contour,
                                           const Outline& outline, const FitView& view,
                                           const OutlineTerms& terms, double* gap_px) {
  std::vector<Constraint> constraints;
  double sum = 0, length = 0;
  for (const auto& matches : {MatchToOutline(contour, outline, terms.reach_px),
                              MatchFromOutline(contour, outline, terms.reach_px)})
    for (const OutlineMatch& match : matches) {
      AddContourPull(points, contour[match.contour], match, view, terms, constraints);
      sum += std::abs(match.distance_px) * match.length_px;
      length += match.length_px;
    }
  if (gap_px) *gap_px = length > 0 ? sum / length : 0;
  return constraints;
}

std::vector<Constraint> AppearanceConstraints(const PointsX3& points,
                                              const std::vector<SeenVertex>& seen,
                                              const std::vector<PatchShift>& shifts,
                                              const Eigen::VectorXd& areas, const FitView& view,
                                              double weight, double scale_px) {
  std::vector<Constraint> constraints;
  for (int i = 0; i < SizeOf(seen); ++i) {
    const PatchShift& patch = shifts[i];
    if (!patch.found) continue;
    const Eigen::Vector3d x = points.row(seen[i].vertex);
    double footprint = 0;
    const Eigen::Matrix<double, 2, 3> j = ScaledJacobian(view, x, &footprint);
    const double w = weight * areas[seen[i].vertex] * patch.correlation * patch.correlation *
                     seen[i].facing * RobustWeight(patch.shift.norm(), scale_px);
    // The goal moves parallel to the picture; along the ray q has no weight.
    const Eigen::Vector3d move =
        footprint * (j.transpose() * (j * j.transpose()).inverse() * patch.shift);
    constraints.push_back({view.index, seen[i].vertex, Eigen::Vector3d::Zero(),
                           w * j.transpose() * patch.confidence * j, x + move});
  }
  return constraints;
}

}  // namespace keypose::fit
