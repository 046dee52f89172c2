// A printed mat whose scale looks alike after each tick, and its photographs, for tests.
#pragma once

#include <Eigen/Core>
#include <random>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::reconstruct::testing {

/// A white mat of radius 1 on a dark table: a scale with 36 ticks and four marks that a quarter of
/// a turn brings onto each other; if asked three coloured spots that are there once.
/// @return RGB, 0 to 255
Eigen::Vector3d MatColour(const Eigen::Vector2d& x, bool with_spots);

/// What a camera shows of the mat at z = 0, with noise of three grey values.
Image8 MatFrom(const View& view, bool with_spots, std::mt19937& random);

}  // namespace keypose::reconstruct::testing
