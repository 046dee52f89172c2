// Non-rigid iterative closest points with landmarks: the paper's registration.
#pragma once

#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "register/nricp/alignment.h"
#include "register/nricp/nricp_system.h"

namespace keypose::registration {

struct NricpOptions {
  double alpha_max = 50;   ///< stiffness of the first round, with the target's diagonal scaled to 2
  double alpha_min = 0.2;  ///< stiffness of the last round
  int alpha_steps = 12;    ///< rounds, falling geometrically
  double beta_ratio = 2;   ///< landmark weight over stiffness
  double beta_until = 1;   ///< landmarks count while the stiffness is above this
  double gamma = 1;  ///< weight of translation against rotation and scale in the stiffness term
  double epsilon = 1e-3;  ///< an inner loop ends when |X - X before|_F / sqrt(V) is below
  int max_inner = 10;     ///< or after this many solves
  /// factor at every solve, instead of conjugate gradients with the last factor
  bool exact_solves = false;
};

struct NricpResult {
  PointsX3 points;  ///< V x 3, in the target's frame
  /// V, linear part of each vertex's affine map from source to target frame
  std::vector<Eigen::Matrix3d> transforms;
  Alignment alignment;
  int iterations = 0;  ///< pairs of a search and a solve, over all rounds
  int factorisations = 0, analyses = 0;
  long pcg_steps = 0;
  int unconverged_rounds = 0;  ///< rounds that ended at max_inner
  double kept = 0;             ///< share of vertices whose correspondence was used at the end
  int loose_components = 0;    ///< parts of the source that nothing held in place, the most in one
                               ///< round
  double seconds_align = 0, seconds_search = 0, seconds_solve = 0;
};

/// Bends the source onto the target with one affine map per vertex. The stiffness falls from round
/// to round.
///
/// @param source     V >= 1 vertices; may be open and have several parts
/// @param target     any usable mesh, open or closed
/// @param landmarks  may be empty; then alignment is by ICP, see alignment.h
/// @param stiffness  V, factor on alpha at each vertex, or empty
/// @throws InputError   unusable mesh, landmark off the source, stiffness of wrong length or not
/// positive
/// @throws SolverError  the system cannot be solved
/// @throws Cancelled
/// Cost: one analysis; per round a few closest point searches and solves.
/// Same bits for any thread count.
/// Source: Ebner et al., E-StopMotion, Algorithm 1 (the printed test of its inner loop is
/// reversed), after Amberg et al. 2007.
/// Departs: between factorisations, systems are solved by conjugate gradients to 1e-5 of the
/// right-hand side (exact_solves turns that off).
NricpResult RegisterNricp(const Mesh& source, const Mesh& target,
                          const std::vector<LandmarkGoal>& landmarks,
                          const Eigen::VectorXd& stiffness, const NricpOptions& options,
                          Progress* progress = nullptr);

}  // namespace keypose::registration
