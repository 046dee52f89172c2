// The few shapes whose weighted sums come closest to many pictures of one mesh.
#pragma once

#include "core/values/progress.h"
#include "export/gltf/weighted_shapes.h"

namespace keypose::exporting {

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
