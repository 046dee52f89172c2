// The visual hull of exact silhouettes: the best that masks alone can give, to measure stereo
// against.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"

namespace keypose::synth {

/// The set of points whose pixels lie in every mask, as a closed mesh.
///
/// @param masks      one a view, of its camera's size; > 127 is character
/// @param low, high  box round the character [m]
/// @param spacing    of the polygonisation [m]
/// @throws InputError  as many masks as views are needed, of their size; nothing in common
/// Same bits for any thread count.
/// Source: Laurentini, TPAMI 1994.
Mesh HullOfMasks(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const Eigen::Vector3d& low, const Eigen::Vector3d& high, double spacing);

}  // namespace keypose::synth
