// Scenes with known cameras and points, for tests.
#pragma once

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/values/camera.h"

namespace keypose::reconstruct::testing {

/// Cameras on rings (elevation, count) about +z at 4 units, directed at (0, 0, 0.5), in the true
/// frame; points on a blob there.
/// @param arc    of each ring that has cameras [rad]
/// @param roll   of the cameras about their axes [rad]
/// @param noise  of the cameras' positions
Scene RingScene(const std::vector<std::pair<double, int>>& rings, double arc, double roll,
                double noise, std::mt19937& random);

/// Camera k of a ring of `count` about z, directed at the unit ball at the origin.
View BallCamera(int k, int count, double height = 2);

/// Points spread over the unit ball, with errors of `noise`, and with the views that see them.
Scene PointsOnBall(const std::vector<View>& views, int count, double noise);

/// A camera directed at the origin, z up.
View LookFrom(const Eigen::Vector3d& eye, const Camera& camera, const std::string& name);

SparsePoint PointAt(const Eigen::Vector3d& x);

}  // namespace keypose::reconstruct::testing
