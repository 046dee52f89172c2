// Scenes whose cameras and points are known, for tests.
#pragma once

#include <random>
#include <string>
#include <utility>
#include <vector>

#include "core/camera.h"

namespace keypose::reconstruct::testing {

/// Cameras on rings (elevation, count) about +z at 4 units, looking at (0, 0, 0.5), in the frame of
/// truth; points on a blob there.
/// @param arc   of each ring that the cameras take [rad]
/// @param roll  of the cameras about their axes [rad]
/// @param noise  of the cameras' places
Scene RingScene(const std::vector<std::pair<double, int>>& rings, double arc, double roll,
                double noise, std::mt19937& random);

/// Camera k of a ring of `count` about z, which looks at the unit ball at the origin.
View BallCamera(int k, int count, double height = 2);

/// Points spread over the unit ball, off by `noise`, with the views that see them.
Scene PointsOnBall(const std::vector<View>& views, int count, double noise);

/// A camera that looks at the origin, z up.
View LookFrom(const Eigen::Vector3d& eye, const Camera& camera, const std::string& name);

SparsePoint PointAt(const Eigen::Vector3d& x);

}  // namespace keypose::reconstruct::testing
