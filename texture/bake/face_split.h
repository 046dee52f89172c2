// Splits faces until they are so small that one colour shift per vertex follows the light.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::texture {

/// For each face, the pixels per unit of length (perpendicular to the ray) in the view that shows
/// it largest; 0 where no view is in front of it. Occlusion is ignored.
Eigen::VectorXd PixelsPerUnit(const Mesh& mesh, const std::vector<View>& views);

/// Splits every face into four at the middles of its edges, repeatedly, until the median face
/// covers at most 400 pixels (or there would be more than 400,000 faces). The surface and its
/// texture coordinates do not change.
Mesh SplitLargeFaces(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::texture
