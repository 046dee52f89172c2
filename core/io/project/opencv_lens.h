// Lenses as OpenCV, ROS and Kalibr write them: K, coefficients, and the model's name.
#pragma once

#include <string>
#include <vector>

#include "core/values/lens.h"

namespace keypose {

/// What a file calls its model, of every spelling that is known, in lower case:
/// - "", plumb_bob, radtan, brown, opencv, pinhole, perspective, standard: 0, 2, 4, 5, 8, 12 or 14
///   coefficients of OpenCV; rational_polynomial: 8; thin_prism: 12; tilted: 14
/// - equidistant, equi, fisheye, opencv_fisheye, kannala_brandt: k1 to k4
/// - fov: w; none: no coefficient
/// @param k  fx, fy, cx, cy, skew; cx and cy count from the centre of the first pixel, as OpenCV's
/// @param where  file and camera, for messages
/// @throws InputError  another model, which it names; a number of coefficients that the model has
/// not
Lens OpenCvLens(const std::string& model, const std::vector<double>& k,
                const std::vector<double>& coefficients, const std::string& where);

/// Whether a word names a lens model, one of OpenCvLens or another. What files call `model` may
/// also be the camera's product.
bool IsLensModelName(const std::string& name);

}  // namespace keypose
