// Volumes and paths of the separate bodies of a solid.
#pragma once

#include <array>
#include <vector>

#include "core/values/mesh.h"
#include "interpolate/volume/tetrahedralize.h"

namespace keypose::interpolation {

/// Path of each body's centroid: the whole solid's centroid moves on a straight line, the bodies'
/// offsets from it turn with the whole.
class BodyPaths {
 public:
  BodyPaths(const PointsX3& v, const PointsX3& u, const Solid& solid, const Eigen::Vector3d& turn);
  /// Moves each body so that the centroid of its surface's vertices lies on its path at time t.
  void Apply(double t, PointsX3& points) const;

 private:
  PointsX3 Means(const PointsX3& points) const;
  const std::vector<int>& body_;
  Eigen::Index points_, bodies_;
  PointsX3 start_, end_;
  Eigen::Vector3d whole_start_, whole_end_, turn_;
  Eigen::Matrix3d rotation_;
};

/// Volume of each body, relative to one of its own vertices for accuracy far from the origin.
Eigen::VectorXd BodyVolumes(const PointsX3& p, const FacesX3& faces, const Solid& solid);

/// A volume as a cubic polynomial of a step.
struct Cubic {
  std::array<double, 4> c = {0, 0, 0, 0};  // of 1, x, x^2, x^3
  double At(double x) const { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }
  /// The step from 0 that reaches `goal`; 0 where Newton's method does not converge.
  double Reach(double goal) const;
};

/// Each body's volume at p + x z as a cubic of x.
std::vector<Cubic> VolumesAlong(const PointsX3& p, const PointsX3& z, const FacesX3& faces,
                                const Solid& solid);

}  // namespace keypose::interpolation
