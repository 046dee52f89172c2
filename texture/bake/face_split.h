// Faces small enough that one colour shift a vertex follows the light.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/mesh.h"

namespace keypose::texture {

/// For each face, how many pixels the view that shows it largest has for a unit of length across
/// the line of sight; 0 where no view is in front of it. Occlusion is not looked at.
Eigen::VectorXd PixelsPerUnit(const Mesh& mesh, const std::vector<View>& views);

/// Splits every face into four at the middles of its edges, and again, until the median face covers
/// at most 400 pixels (or there would be more than 400,000 faces). The surface and its texture
/// coordinates stay as they are.
Mesh SplitLargeFaces(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::texture
