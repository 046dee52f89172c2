// A basis of shapes whose largest error is small, at the cost of the mean error.
#pragma once

#include "export/gltf/weighted_shapes.h"

namespace keypose::exporting {

/// Lowers the largest error of a least-squares basis, with as many targets.
///
/// @param start  weights with columns of similar size
/// @param bound  what is small enough; ends early there
/// @return a basis that is at least as good as `start`
/// Same bits for any thread count. Weights and shapes are fitted in turn so that the sum of a power
/// of all distances falls, and the power grows from 2 to 100. The weights are fitted to at most
/// 4,000 vertices: half of them those with the largest errors, the others evenly chosen.
/// Source: least p-th powers by reweighted least squares with growing p, Burrus, Barreto &
/// Selesnick, IEEE Trans. Signal Processing 1994.
MorphBasis MinimaxBasis(const Pictures& pictures, MorphBasis start, double bound,
                        Progress* progress);

}  // namespace keypose::exporting
