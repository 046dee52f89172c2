// The distance between two surfaces, one way at a time, as statistics and as a value per vertex for
// a coloured picture.
#pragma once

#include "core/values/mesh.h"

namespace keypose::report {

/// Distances from the points of one surface to the closest points of another.
struct OneWayDistance {
  Eigen::VectorXd at_vertex;          ///< V
  double mean = 0, rms = 0, p99 = 0;  ///< over points spread uniformly by area
  /// over those and all vertices: a lower bound of the one-sided Hausdorff distance
  double max = 0;
};
/// @param samples  number of points spread over `from`; more points miss less of a maximum inside a
/// face
OneWayDistance DistanceTo(const Mesh& from, const Mesh& to, int samples = 50000);

}  // namespace keypose::report
