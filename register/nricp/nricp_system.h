// The sparse linear system of one step of non-rigid ICP, with one affine map per vertex.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"

namespace keypose::registration {

/// The terms that change from step to step.
struct NricpTerms {
  double alpha = 1;         ///< stiffness
  double gamma = 1;         ///< weight of the translation part in the stiffness term
  double beta = 0;          ///< weight of landmarks
  Eigen::VectorXd weights;  ///< V, w_i in {0,1}: whether closest point i counts
  PointsX3 closest;         ///< V x 3, u_i
  PointsX3 landmarks;       ///< L x 3, goals of the landmarks
};

/// The energy of one step, and its minimiser:
///
/// E(X) = sum_edges |alpha m_e (X_i - X_j) G|^2 + sum_i w_i |v_i X_i - u_i|^2
///        + beta^2 sum_l |landmark_l - goal_l|^2
///
/// X is 4V x 3: rows 4i..4i+3 hold the map of vertex i, which takes [x y z 1] to [x y z 1] X_i. G =
/// diag(1, 1, 1, gamma). A landmark inside a face moves with its corners' maps, mixed by its
/// barycentric weights.
///
/// The pattern of the normal matrix never changes. It is analysed once (nested dissection of the
/// V-node graph, expanded to 4V) and refilled through a table of slots. Parts of the mesh that no
/// term holds in place get a weak pull (1e-9 of their mean diagonal) to their current position, so
/// the solution is never NaN.
/// Source: Amberg, Romdhani, Vetter, CVPR 2007; Ebner et al., E-StopMotion, Eq. 1-5.
/// Departs: landmark goals have the factor beta on both sides of the system, which the printed
/// Eq. 5 leaves out; the printed Eq. 4 leaves out X.
/// Not for use from two threads at once.
/// Same bits for any thread count.
class NricpSystem {
 public:
  /// @param points     V x 3, at rest
  /// @param stiffness  V, m_i >= 0 of each vertex (m_e is the geometric mean of an edge's two
  ///                   ends), or empty: all are 1
  /// @throws InputError   wrong sizes
  /// @throws SolverError  the pattern cannot be analysed
  NricpSystem(const PointsX3& points, const FacesX3& faces,
              const std::vector<SurfacePoint>& landmarks, const Eigen::VectorXd& stiffness = {});
  ~NricpSystem();
  NricpSystem(NricpSystem&&) noexcept;

  /// Sets the terms and fills the matrix.
  /// @param current  current X; parts that nothing holds in place stay there
  /// @throws InputError  wrong sizes
  void Refill(const NricpTerms& terms, const Eigen::MatrixXd& current);
  /// Factors the matrix and solves.
  /// @throws SolverError  not positive definite, out of memory, or a solution that is not finite
  Eigen::MatrixXd SolveDirect();
  /// Solves by conjugate gradients from `start`, preconditioned with the last factor, until the
  /// residual is below `tolerance` times the right-hand side. Calls SolveDirect when there is no
  /// factor, or when `max_steps` are not enough.
  Eigen::MatrixXd SolveNear(const Eigen::MatrixXd& start, double tolerance, int max_steps);

  Eigen::MatrixXd Identity() const;                   ///< X where every map is the identity
  PointsX3 Deformed(const Eigen::MatrixXd& x) const;  ///< V x 3, v_i X_i
  double Energy(
      const Eigen::MatrixXd& x) const;  ///< of the last Refill, term by term from the definition
  Eigen::MatrixXd HalfGradient(
      const Eigen::MatrixXd& x) const;  ///< A^T (A X - B) from the assembled system

  int analyses() const;
  int factorisations() const;
  long pcg_steps() const;
  int loose_components() const;  ///< connected parts that needed the weak pull at the last Refill
  long factor_nonzeros() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::registration
