// A ball with bumps.
#pragma once

#include <Eigen/Dense>
#include <cmath>

#include "core/surfaces/shapes.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// A body without symmetry: a sphere with smooth bumps.
inline Mesh Bumpy(int levels) {
  Mesh mesh = MakeIcosphere(levels);
  for (Eigen::Index i = 0; i < mesh.points.rows(); ++i) {
    const Eigen::Vector3d p = mesh.points.row(i);
    mesh.points.row(i) = p.transpose() * (1 + 0.25 * std::sin(2 * p.x() + 1) +
                                          0.35 * std::cos(3 * p.y() + 0.5 * p.x()) + 0.3 * p.z());
  }
  return mesh;
}

}  // namespace keypose::registration
