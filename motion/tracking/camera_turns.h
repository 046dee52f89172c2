// Cameras that were touched since they were calibrated: small turns, found from a tracked body.
#pragma once

#include <vector>

#include "motion/tracking/pose_solver.h"

namespace keypose::motion {

/// One frame: what all cameras show, and a pose near that in which the body was.
struct TurnFrame {
  std::vector<Silhouette> silhouettes;
  BodyPose pose;
};

struct CameraTurns {
  /// per camera, in world [rad]: the camera is turned by so much against its calibration, about its
  /// own centre
  std::vector<Eigen::Vector3d> turns;
  std::vector<double> shift_px;  ///< how far that moves the actor in the silhouettes' pictures
  double before = 0, after = 0;  ///< robust cost of the outlines per measurement [px^2]
};

/// Turns that let the outlines of all cameras agree on one body. Poses and turns are fitted by
/// turns: the outlines of each camera, over all frames, say how it is turned, and the body follows.
///
/// @param frames  eight or more, spread over the performance; all of the same cameras
/// @return all 0 where a camera shows nothing
/// Same bits for any thread count.
CameraTurns FindCameraTurns(std::vector<TurnFrame> frames, const BodyShape& shape);

/// The camera's place after it was turned about its centre by a rotation vector in world.
Rigid3 TurnedBy(const Rigid3& camera_from_world, const Eigen::Vector3d& turn);

}  // namespace keypose::motion
