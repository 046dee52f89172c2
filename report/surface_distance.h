// How far two surfaces lie apart, both ways, as numbers and as a value at each vertex for a
// coloured picture.
#pragma once

#include "core/mesh.h"

namespace keypose::report {

/// From the points of one surface to the closest point of another.
struct OneWayDistance {
  Eigen::VectorXd at_vertex;          ///< V
  double mean = 0, rms = 0, p99 = 0;  ///< over points spread uniformly by area
  double max = 0;  ///< over those and all vertices: the one-sided Hausdorff distance, from below
};
/// @param samples  points spread over `from`; their number bounds how much of a maximum inside a
/// face can be missed
OneWayDistance DistanceTo(const Mesh& from, const Mesh& to, int samples = 50000);

}  // namespace keypose::report
