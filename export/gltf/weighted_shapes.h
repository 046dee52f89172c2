// Pictures of one mesh as a base and weighted sums of shapes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::exporting {

/// Vertex positions of each picture, V x 3; all with the same V.
using Pictures = std::vector<const PointsX3*>;

/// Picture p is about base + the sum over k of weights(p, k) * targets[k].
struct MorphBasis {
  PointsX3 base;                  ///< V x 3
  std::vector<PointsX3> targets;  ///< K times V x 3: differences to the base
  Eigen::MatrixXd weights;        ///< P x K
};

/// A picture as the basis gives it.
PointsX3 Blended(const MorphBasis& basis, Eigen::Index picture);

/// @return V; the largest distance to its position in any picture
Eigen::VectorXd VertexErrors(const Pictures& pictures, const MorphBasis& basis);

/// The base and targets with the smallest squared distances, for given weights.
MorphBasis LeastSquaresBasis(const Pictures& pictures, const Eigen::MatrixXd& weights);

}  // namespace keypose::exporting
