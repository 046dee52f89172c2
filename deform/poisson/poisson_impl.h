// The implementation of PoissonSystem, used by its sources only.
#pragma once

#include <Eigen/LU>
#include <Eigen/SparseCore>
#include <array>

#include "deform/poisson/poisson.h"
#include "deform/solvers/block_cholesky.h"

namespace keypose {

constexpr int kVectorWidth = 4;
/// chosen so that the edges of a patch's faces at one vector of frames fit into the L2 cache
constexpr int kPatchRows = 512;

using EdgeWeights = std::array<double, 3>;  ///< of the edges opposite corners 0, 1, 2

/// One face's contribution to a row of unknowns: the face's index in the patch, and the weights of
/// its two edges.
struct RowCorner {
  int face;
  double first, second;
};

struct PoissonSystem::Impl {
  Impl(const KeyRefs& keys, const FacesX3& faces, const PoissonOptions& options);

  void FindParts();
  void BuildIncidence();
  void Weigh(const KeyRefs& keys);
  Eigen::SparseMatrix<double> LowerLaplacian() const;
  void Assemble();
  double Kappa() const { return 1 / (screening_length * screening_length); }

  // In poisson_edges.cpp.
  void CutPatches();
  std::span<const int> FacesOfPatch(int patch) const {
    return {patch_faces.data() + patch_begin[patch], patch_faces.data() + patch_begin[patch + 1]};
  }
  /// Writes the patch's rows at frames first .. first + 3, from the edges of its faces (of all
  /// faces, when the batch lists none).
  void Gather(int patch, const EdgeBatch& edges, const Eigen::Matrix3d* turns, int first,
              FrameRows& sums) const;
  void RightHandSide(const FillEdges& fill, const std::vector<Eigen::Matrix3d>& turns,
                     FrameRows& sums) const;
  void Fit(FrameRows& solved, const std::vector<RowTargets>& targets,
           std::vector<PointsX3>& frames) const;
  /// Right-hand sides of one frame: rows of four numbers, x y z 0.
  std::vector<double> OneRightHandSide(const FillOneFrame& fill, const Eigen::Matrix3d& turn) const;

  // In poisson_rows.cpp.
  void AcceptRows(const std::vector<ConstraintRow>& given);
  void AddCentroidRows();
  void FactorRows();
  /// C (system)^-1 C^T for the coupled rows.
  Eigen::MatrixXd Compliance(const BlockCholesky& system,
                             const std::vector<ConstraintRow>& some) const;
  Eigen::MatrixXd ValuesOf(const std::vector<ConstraintRow>& some, const Eigen::MatrixXd& x) const;
  void SolveWithRows(Eigen::MatrixXd& rhs, const std::vector<RowTargets>& targets) const;
  void CentreFreeParts(PointsX3& points, const RowTargets& targets) const;

  Eigen::Index n = 0;
  FacesX3 faces;
  PoissonOptions options;
  // for each vertex: the lowest vertex of its part, and its part; for each part: its vertex count
  std::vector<int> lowest, parts, part_size;
  int part_count = 0;
  std::vector<int> first_corner, corners;
  std::vector<EdgeWeights> weights;
  Eigen::VectorXd area, mass;
  double screening_length = 0;
  BlockCholesky solver, screened;

  /// Patches: up to kPatchRows rows each, in the solver's order, and all faces that touch them.
  std::vector<int> patch_begin, patch_faces, row_begin;
  std::vector<RowCorner> row_corners;

  std::vector<ConstraintRow> rows;
  std::vector<int> sources;
  std::vector<std::string> dropped;
  int coupled = 0;  // number of rows that are solved by multipliers; they come first, the others
                    // are centroids of parts that no other row touches
  std::vector<int> touched_parts;  // parts that coupled rows reach
  Eigen::MatrixXd part_sums;       // coupled x touched: sums of the rows' weights over each part
  Eigen::MatrixXd compliance;      // C H^-1 C^T + diag(compliance)
  Eigen::PartialPivLU<Eigen::MatrixXd> multipliers;
  std::vector<ConstraintRow> exact;  // of the coupled rows
  Eigen::PartialPivLU<Eigen::MatrixXd> exact_screened;
};

}  // namespace keypose
