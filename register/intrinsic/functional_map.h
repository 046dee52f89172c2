// Functional maps: maps between two surfaces in the bases of their eigenfunctions, and the point
// maps that belong to them.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::registration {

/// Points of a surface, one per row: the values of the lowest eigenfunctions, and the area that the
/// point represents.
struct SpectralPoints {
  Eigen::MatrixXf functions;  ///< P x K
  Eigen::VectorXf weights;    ///< P, positive
};

/// Maps between two point sets, in both directions. They need not be one-to-one.
struct PointMaps {
  std::vector<int> forward;   ///< source point -> target point
  std::vector<int> backward;  ///< target point -> source point
};

/// Additional columns for matching, beside the eigenfunctions.
struct MatchHints {
  Eigen::MatrixXf source, target;  ///< P x H each, or empty
  double weight = 0;  ///< total variance of these columns over that of the functions in use
};

/// The nearest row of `b` for each row of `a`, and of `a` for each row of `b`. Ties: lowest index.
PointMaps NearestRows(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b);

/// Refines point maps. Each round fits functional maps to both point maps by least squares, then
/// matches the points again with both functional maps.
///
/// @param start  maps between the points of `source` and `target`
/// @param sizes  number of functions in each round, rising, at most K
/// @param hints  more columns that matched points should agree in; a few functions alone cannot
///               tell the front of a flat body from its back
/// Deterministic.
/// Cost: per round one P x P x 2K product.
/// Source: Melzi et al., ZoomOut, SIGGRAPH Asia 2019; both directions as in Ren et al., MapTree,
/// SIGGRAPH Asia 2020.
PointMaps RefineMaps(const SpectralPoints& source, const SpectralPoints& target, PointMaps start,
                     const std::vector<int>& sizes, const MatchHints& hints = {});

/// Functional maps in both directions. They turn eigenfunction values into rows such that points
/// that belong together have near rows. Works for any points of the two surfaces.
struct JointEmbedding {
  Eigen::MatrixXf pull_forward;   ///< K x K, from functions of the target to those of the source
  Eigen::MatrixXf pull_backward;  ///< K x K, from functions of the source to those of the target
  Eigen::MatrixXf SourceRows(const Eigen::MatrixXf& functions) const;
  Eigen::MatrixXf TargetRows(const Eigen::MatrixXf& functions) const;
};
/// Least squares fit to both point maps, with at most `size` functions.
JointEmbedding FitEmbedding(const SpectralPoints& source, const SpectralPoints& target,
                            const PointMaps& maps, int size);

}  // namespace keypose::registration
