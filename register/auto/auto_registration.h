// Registration that survives far-turned limbs: landmarks first, then the surface, from coarse to
// fine and from stiff to soft.
#pragma once

#include <string>
#include <vector>

#include "core/landmark_goal.h"
#include "core/mesh.h"
#include "core/progress.h"
#include "register/nricp/alignment.h"

namespace keypose::registration {

struct AutoOptions {
  int coarse_vertices = 500;       ///< level on which starts are tried
  int middle_vertices = 1700;      ///< level on which the surface is found
  double landmark_weight = 50;     ///< pull of a landmark at first, in units of the shape term
  double landmark_weight_end = 5;  ///< and at the end: picks carry noise
  double smoothing = 0.02;         ///< maps vary little over less than this, over the diagonal
  double good_fit = 0.00065;  ///< stay rigid where the surfaces are this close while the shape is
                              ///< still stiff, over the diagonal
  double poor_fit = 0.002;    ///< try another start when they are further apart than this
  /// with fewer than four landmarks, also start from a map found by intrinsic geometry
  bool suggest = true;
  bool skeleton = true;  ///< also start from curve skeletons when all other starts are poor

  /// One sentence per fault, naming field, value and range; empty when valid.
  std::vector<std::string> Problems() const;
};

/// One way to begin, and how it did on the coarse level.
struct StartTrial {
  std::string name = {};   ///< "landmarks", "landmarks, softer", "intrinsic map", "skeleton", ...
  double gap = 0;          ///< between the surfaces, both ways, over the diagonal
  double strain = 0;       ///< mean of the squared strain
  double score = 0;        ///< smaller is better
  std::string words = {};  ///< what the start has to say of itself, or why it could not be made
};

struct AutoResult {
  PointsX3 points;                          ///< V x 3, in the target's frame
  std::vector<Eigen::Matrix3d> transforms;  ///< V, linear part of each vertex's map: near v_i, x
                                            ///< moves to transforms[i] (x - v_i) + points.row(i)
  Alignment alignment;
  std::vector<StartTrial> starts;  ///< in the order of trial
  int chosen = 0;                  ///< of starts
  bool softened = false;           ///< the shape had to give way to reach the surface
  int levels = 1;
  int loose_parts = 0;    ///< moved with what they sit on
  int seam_vertices = 0;  ///< of the source, doubles of others, moved as one with those
  double gap = 0;         ///< at the end, as in StartTrial
  double scale = 1;       ///< of the template in the pose
};

/// The source bent onto the target, with landmarks or without, however far limbs have turned.
///
/// 1. Rigid start: Procrustes on landmarks or multi-start ICP, sized by surface areas where both
/// are whole. 2. On a coarse level, starts compete: landmarks pull an as-rigid-as-possible mesh;
/// vertices are matched by their distances along the surface to the landmarks; with few landmarks
/// an intrinsic map is found; softer shape and curve skeletons follow when the fit is poor. 3. The
/// surfaces pull at each other by point-to-plane distances with robust weights while stiffness
/// falls; where rigid parts cannot explain the pose, maps become smoothly affine. 4. Finer levels
/// follow. Separate small parts move with what they sit on.
///
/// Seams, where vertices are doubled for texture coordinates, are closed for the fit in both
/// meshes: all doubles move as one.
///
/// @param source     V >= 4 vertices; open, closed, several parts, all allowed
/// @param target     any usable mesh; open boundaries do not pull
/// @param landmarks  may be empty
/// @param stiffness  V, multiplies the shape term at each vertex, or empty
/// @throws InputError   unusable mesh, landmark off the source, stiffness of another length or not
/// positive
/// @throws SolverError
/// @throws Cancelled
/// Cost: near-linear.
/// Same bits for any thread count. See docs/stages/register.md.
AutoResult RegisterAuto(const Mesh& source, const Mesh& target,
                        const std::vector<LandmarkGoal>& landmarks,
                        const Eigen::VectorXd& stiffness, const AutoOptions& options,
                        Progress* progress = nullptr);

/// The part of RegisterAuto that bends: one surface without seams or loose parts, and inputs that
/// were checked.
AutoResult RegisterSurface(const Mesh& source, const Mesh& target,
                           const std::vector<LandmarkGoal>& landmarks,
                           const Eigen::VectorXd& stiffness, const AutoOptions& options,
                           Progress* progress);

}  // namespace keypose::registration
