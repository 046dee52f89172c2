// How much brighter one picture of a set is than another.
#pragma once

#include <Eigen/Core>

#include "core/values/image.h"

namespace keypose::composite {

/// Factors per channel (exposure and white balance): picture = factor * plate where both show the
/// same. The median over pixels that are neither black nor burnt out, so that what moved does not
/// count.
///
/// @param picture, plate  RGB, linear light, the same size
/// @param away            1 channel: > 127 where pixels do not count; empty: all count
/// @return 1, 1, 1 when fewer than 200 pixels count
Eigen::Vector3d ExposureOf(const ImageF& picture, const ImageF& plate, const Image8& away);

}  // namespace keypose::composite
