// What moves the points of a pose: steps along a field, and pulls.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

struct PointMoves {
  const Eigen::Matrix<double, Eigen::Dynamic, 3>* field = nullptr;  ///< V x 3, or none
  const std::vector<int>* parts = nullptr;                          ///< of the vertices
  const std::vector<double>* along = nullptr;                       ///< step of each part

  const Eigen::MatrixXd* columns = nullptr;  ///< V x P: how far each vertex follows a pull; or none
  std::vector<int> pulled;                   ///< columns that are pulled
  Eigen::MatrixXd pulls;                     ///< a row of three for each
};

/// Moves the points in place.
/// @return the largest displacement by pulls
double MovePoints(const PointMoves& moves, PointsX3& points);

}  // namespace keypose::motion
