// Feet: which patches of a mesh stand on the ground, when, and what keeps them where they stand.
#pragma once

#include <functional>
#include <vector>

#include "core/values/mesh.h"

namespace keypose::motion {

/// A patch of the surface that can stand on the ground: a sole, or the heel or toe half of one.
struct SolePatch {
  std::vector<int> vertices;
  Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();  ///< mean of the vertices, at rest
};

/// The patches of a mesh that stands upright (z up): connected vertices within 3 % of its height
/// above its lowest point. A patch that is longer than wide is cut in two across.
/// @return ordered by their lowest vertices; empty when the mesh has no height
std::vector<SolePatch> FindSoles(const PointsX3& points, const FacesX3& faces);

/// For each target patch the template's nearest one, or -1 when none is near (15 % of the height).
/// @param target_from_template  places a point of the template's reference on the target
std::vector<int> PairSoles(
    const std::vector<SolePatch>& on_template, const std::vector<SolePatch>& on_target,
    const std::function<Eigen::RowVector3d(const Eigen::RowVector3d&)>& target_from_template,
    double target_height);

/// Where a patch is in each frame.
struct SoleTrack {
  PointsX3 centres;        ///< T x 3
  Eigen::VectorXd lowest;  ///< T, z of its lowest vertex
};

/// Frames in which a patch stands: low (within 3 % of the height above the lowest it comes) and
/// slow (under 15 % of the height a second). Gaps of up to two frames are closed, and contacts of
/// fewer than three frames dropped.
/// @param height  of the figure, and `fps` the frames per second
/// @return T, 1 where it stands
std::vector<char> FindContacts(const SoleTrack& track, double height, double fps);

/// How one patch is held.
struct PatchHold {
  /// T x 3, displacements from where the patch would be; 0 where nothing holds it
  PointsX3 moves;
  /// T: 1 where the displacement brings it exactly to its place, less while easing in or out, else
  /// 0
  Eigen::VectorXd firmness;
};

/// Holds a patch at one place in each run of frames.
/// @param centres  T x 3, where it would be
/// @param held     T, 1 where it is held
/// @param place    of a run, from its first frame and the one after its last
PatchHold HoldRuns(const PointsX3& centres, const std::vector<char>& held,
                   const std::function<Eigen::RowVector3d(int first, int end)>& place);

/// What keeps feet from sliding: how far the whole body moves, and where patches are held.
struct FootPlan {
  PointsX3 shift;                ///< T x 3, added to the root's path
  std::vector<PatchHold> holds;  ///< of each patch, after the shift
};

/// Plans a motion whose feet do not slide.
///
/// The shift is the smooth path whose velocity cancels, in each frame, the mean velocity of the
/// patches that stand, and whose height brings them to their height at rest: so a walk gets the
/// steps that the target's own legs make. What remains, patch by patch, is a displacement to the
/// mean place of each contact, eased over five frames before and after.
/// @param tracks    of the target's patches, without correction
/// @param contacts  of each patch, T
/// @param heights   z of each patch's centre when it stands
FootPlan PlanFeet(const std::vector<SoleTrack>& tracks,
                  const std::vector<std::vector<char>>& contacts,
                  const std::vector<double>& heights);

}  // namespace keypose::motion
