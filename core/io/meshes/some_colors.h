// Colours of vertices of which only some have one.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// Colours of all vertices. Those from 0 to 1 are fractions; if any is above 1, all are levels of
/// 255. A vertex without one takes the mean of its neighbours that have one, ring by ring; of a
/// part without any colour, the mean of all.
/// @param colored  vertices that have a colour, ascending
/// @param colors   as many; sRGB
/// @return V x 3, or empty where no vertex has a colour
ColorsX3 ColorsOfSome(const std::vector<std::size_t>& colored,
                      const std::vector<Eigen::Vector3d>& colors, const FacesX3& faces,
                      Eigen::Index vertices);

}  // namespace keypose
