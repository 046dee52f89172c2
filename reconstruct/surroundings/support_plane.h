// The plane that the figure stands on, from the points of structure from motion.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/values/camera.h"

namespace keypose::reconstruct {

struct SupportPlaneOptions {
  double reach = 0.6;  ///< points within this share of the cameras' distance to the figure count
  double thickness = 0.004;  ///< of that distance: points of the plane lie within this
  int fewest = 30;           ///< points of the plane
  double share = 0.12;       ///< and of the points within reach
  /// upwards, where that is known roughly: the plane is level within `tilt`
  std::optional<Eigen::Vector3d> up = std::nullopt;
  double tilt = 0.7;  ///< [rad]
};

struct SupportPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  ///< unit, towards the cameras
  double offset = 0;                                  ///< normal . x = offset on the plane
  Eigen::Vector3d foot = Eigen::Vector3d::Zero();  ///< on the plane, below what the cameras look at
  double distance = 0;  ///< median of the cameras' distances to what they look at
  int points = 0;
};

/// What most cameras look at: the point nearest to their optical axes, robustly.
/// @throws InputError  fewer than 2 views
Eigen::Vector3d LookedAt(const std::vector<View>& views);

/// The plane with most points around what the cameras look at, nearer ones counting more, among
/// those that have the cameras on one side and what they look at not below. A table, a mat, a book
/// and a plinth's top are found; a wall behind the figure has what the cameras look at before it
/// and few points near it.
/// @return nothing where there is no such plane, as under plain cloth
/// Same result for any thread count.
std::optional<SupportPlane> FindSupportPlane(const Scene& scene,
                                             const SupportPlaneOptions& options = {});

}  // namespace keypose::reconstruct
