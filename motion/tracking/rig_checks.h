// Whether cameras, clocks and masks of a shot agree with each other.
#pragma once

#include <vector>

#include "motion/tracking/pose_search.h"

namespace keypose::motion {

struct RigAgreement {
  CoarseHull hull;  ///< of the cameras that agree
  std::vector<int>
      against;  ///< places in `silhouettes` of cameras that see nothing of the others' hull
};
/// The hull of all cameras, without those that contradict the others. All of them contradict each
/// other when `hull.voxels` is 0.
RigAgreement CheckAgreement(const std::vector<Silhouette>& silhouettes,
                            const Eigen::Quaterniond& up_from_world);

/// Whether the camera would agree with the others if its distance from the origin were `factor`
/// times as long, as for one calibrated in millimetres among metres.
bool AgreesScaled(const std::vector<Silhouette>& silhouettes, int camera, double factor,
                  const Eigen::Quaterniond& up_from_world);

/// The directions in which one camera sees the actor's outline in one frame; in world, any length.
using OutlineRays = std::vector<Eigen::Vector3d>;
OutlineRays RaysOf(const Silhouette& silhouette);

struct ClockOffsets {
  std::vector<int>
      frames;         ///< frame f of the shot is frame f + frames[c] of camera c; >= 0, one is 0
  double before = 0;  ///< disagreement of the outlines without offsets [rad]
  double after = 0;   ///< with them
};
/// Offsets between the cameras' clocks. In frames of one instant, the planes through two cameras
/// that touch the actor touch both outlines; the offsets are those for which they agree best over
/// time.
///
/// @param rays     per camera and frame, all of one length
/// @param centers  of the cameras
/// @param middle   a point within the actor's reach
/// @param most     largest offset that is tried [frames]
/// @return all 0 when offsets explain less than a fifth of the disagreement
/// Source: Sinha & Pollefeys, "Synchronization and calibration of camera networks from
/// silhouettes", ICPR 2004. Departs: calibrated cameras, whole frames.
ClockOffsets FindClockOffsets(const std::vector<std::vector<OutlineRays>>& rays,
                              const std::vector<Eigen::Vector3d>& centers,
                              const Eigen::Vector3d& middle, int most);

}  // namespace keypose::motion
