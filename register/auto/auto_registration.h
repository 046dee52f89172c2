// Registration for limbs that turn far: landmarks first, then the surface. Levels go from coarse to
// fine, the shape from stiff to soft.
#pragma once

#include <string>
#include <vector>

#include "core/values/landmark_goal.h"
#include "core/values/mesh.h"
#include "core/values/progress.h"
#include "register/nricp/alignment.h"

namespace keypose::registration {

struct AutoOptions {
  int coarse_vertices = 500;       ///< size of the level on which starts are tried
  int middle_vertices = 1700;      ///< size of the level that is first pulled to the surface
  double landmark_weight = 50;     ///< of a landmark at the start, in units of the shape term
  double landmark_weight_end = 5;  ///< of a landmark at the end; lower, because picks are noisy
  double smoothing = 0.02;         ///< maps vary little within this distance, over the diagonal
  double good_fit = 0.00065;  ///< gap below which the shape stays rigid, measured while it is still
                              ///< stiff, over the diagonal
  double poor_fit = 0.002;    ///< gap above which more starts are tried, over the diagonal
  /// With fewer than four landmarks, also start from an intrinsic map. With landmarks, also when
  /// the gap stays above 1.3 poor_fit.
  bool suggest = true;
  /// With fewer than four landmarks, also start from curve skeletons when the gap is above poor_fit
  bool skeleton = true;

  /// One sentence per fault, naming field, value and range; empty when valid.
  std::vector<std::string> Problems() const;
};

/// One start, and its result on the coarse level.
struct StartTrial {
  std::string name = {};   ///< "landmarks", "landmarks, softer", "intrinsic map", "skeleton", ...
  double gap = 0;          ///< between the surfaces, mean of both ways, over the diagonal
  double strain = 0;       ///< mean of the squared strain
  double score = 0;        ///< smaller is better
  std::string words = {};  ///< a description of the start, or why it could not be made
};

struct AutoResult {
  PointsX3 points;                          ///< V x 3, in the target's frame
  std::vector<Eigen::Matrix3d> transforms;  ///< V, linear part of each vertex's map: near v_i, x
                                            ///< moves to transforms[i] (x - v_i) + points.row(i)
  Alignment alignment;
  std::vector<StartTrial> starts;  ///< in the order of trial
  int chosen = 0;                  ///< index into starts
  bool softened = false;           ///< the shape was softened to reach the surface
  int levels = 1;
  int loose_parts = 0;       ///< parts that moved with the surface they sit on
  int seam_vertices = 0;     ///< source vertices that repeat others at seams and moved with those
  double gap = 0;            ///< at the end, as in StartTrial
  double scale = 1;          ///< target size over template size
  int rigid_parts = 0;       ///< parts that moved as rigid bodies, where those were the start
  double unmoved_share = 0;  ///< of the area that belongs to the first of them
};

/// Bends the source onto the target, with or without landmarks. Limbs may turn far.
///
/// 1. Rigid alignment: Procrustes on landmarks, or ICP from many orientations. The size comes from
///    the ratio of surface areas, except for an open target with exactly three landmarks.
/// 2. Several starts are tried on a coarse level. Landmarks pull an as-rigid-as-possible mesh, and
///    vertices are matched by their distances along the surface to the landmarks. With few
///    landmarks, an intrinsic map is a start too. When the fit is poor, a softer shape and curve
///    skeletons are tried. The start with the lowest score is kept.
/// 3. Both surfaces pull at each other with robust point-to-plane distances while the stiffness
///    falls. If rigid motion cannot reach the target, the maps become smooth affine maps.
/// 4. Finer levels follow. Loose parts move with the surface they sit on.
/// 5. With fewer than four landmarks: if most of the figure moved as one rigid body (see
///    FindRigidParts) and the result has left its place, steps 2 to 4 run again from there.
///
/// Seams, where vertices are doubled for texture coordinates, are closed in both meshes during the
/// fit, so all doubles of a vertex move together.
///
/// @param source     V >= 4 vertices; may be open and have several parts
/// @param target     any usable mesh; open boundaries do not pull
/// @param landmarks  may be empty
/// @param stiffness  V, factor on the shape term at each vertex, or empty
/// @throws InputError   unusable mesh, landmark off the source, stiffness of wrong length or not
/// positive
/// @throws SolverError  a linear system cannot be solved, or the result is not finite
/// @throws Cancelled
/// Cost: near-linear.
/// Same bits for any thread count. See docs/stages/register.md.
AutoResult RegisterAuto(const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkGoal>& landmarks,
                        const Eigen::VectorXd& stiffness, const AutoOptions& options,
                        Progress* progress = nullptr);

/// The core of RegisterAuto, for a source without seams and loose parts and for inputs that were
/// checked.
AutoResult RegisterSurface(const Mesh& source, const Mesh& target,
                           const std::vector<LandmarkGoal>& landmarks,
                           const Eigen::VectorXd& stiffness, const AutoOptions& options,
                           Progress* progress);

}  // namespace keypose::registration
