// Many pictures of one mesh as weighted sums of few shapes.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/mesh.h"
#include "core/progress.h"

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

struct MorphFit {
  MorphBasis basis;
  double largest_error = 0;  ///< of any vertex in any picture
  /// The largest error if as many targets were pictures: each time the one with the largest error
  /// is added, and all weights are refitted.
  double error_of_pictures = 0;
};

/// The fewest targets with which no vertex is farther than `bound` from where it belongs in any
/// picture, or `max_targets` if that takes more. As players blend linearly between weights, errors
/// between two pictures are not larger than at them.
///
/// @param pictures  at least two, of one V, at least one vertex
/// @param max_targets  >= 1
/// Same bits for any thread count. Cost: P^2 V for the principal components; where these are not
/// enough, further rounds over at most 4,000 vertices.
/// Source: principal components of shapes, Alexa & Mueller, Eurographics 2000; then MinimaxBasis.
MorphFit FitMorphBasis(const Pictures& pictures, int max_targets, double bound, Progress* progress);

}  // namespace keypose::exporting
