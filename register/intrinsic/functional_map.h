// Maps between two surfaces, refined back and forth between points and eigenfunctions.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace keypose::registration {

/// Some points of a surface as rows: values of the lowest eigenfunctions there, and how much area
/// each stands for.
struct SpectralPoints {
  Eigen::MatrixXf functions;  ///< P x K
  Eigen::VectorXf weights;    ///< P, positive
};

/// For each point of one set a point of the other. Neither needs to be one-to-one.
struct PointMaps {
  std::vector<int> forward;   ///< source point -> target point
  std::vector<int> backward;  ///< target point -> source point
};

/// Columns beside the eigenfunctions, and their total variance over that of the functions in use.
struct MatchHints {
  Eigen::MatrixXf source, target;  ///< P x H each, or empty
  double weight = 0;
};

/// The nearest row of `b` for each row of `a`, and the other way; ties by index.
PointMaps NearestRows(const Eigen::MatrixXf& a, const Eigen::MatrixXf& b);

/// Alternates: fit K x K maps between the lowest eigenfunctions in least squares to both point
/// maps; then match points by both.
///
/// @param start  maps between the points of `source` and `target`
/// @param sizes  how many functions to use in each round, rising, at most K
/// @param hints  further columns that matched points should agree in; few functions cannot tell a
/// flat body's front from its back Deterministic.
/// Cost: per round one P x P x 2K product.
/// Source: Melzi et al., ZoomOut, SIGGRAPH Asia 2019; both directions as in Ren et al., MapTree,
/// SIGGRAPH Asia 2020.
PointMaps RefineMaps(const SpectralPoints& source, const SpectralPoints& target, PointMaps start,
                     const std::vector<int>& sizes, const MatchHints& hints = {});

/// Rows in which nearest means matched, for the maps given: for use with other points of the same
/// surfaces.
struct JointEmbedding {
  Eigen::MatrixXf pull_forward;   ///< K x K, functions of the target to the source
  Eigen::MatrixXf pull_backward;  ///< K x K, functions of the source to the target
  Eigen::MatrixXf SourceRows(const Eigen::MatrixXf& functions) const;
  Eigen::MatrixXf TargetRows(const Eigen::MatrixXf& functions) const;
};
JointEmbedding FitEmbedding(const SpectralPoints& source, const SpectralPoints& target,
                            const PointMaps& maps, int size);

}  // namespace keypose::registration
