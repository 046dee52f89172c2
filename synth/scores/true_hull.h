// The visual hull of exact silhouettes: the best result from masks alone, for comparison with
// stereo.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// The set of points that project into every mask, as a closed mesh.
///
/// @param masks      one per view, of its camera's size; > 127: character
/// @param low, high  box around the character [m]
/// @param spacing    of the polygonisation [m]
/// @throws InputError  number or sizes of masks and views differ, or the masks have no common
/// point. Same bits for any thread count. Source: Laurentini, TPAMI 1994.
Mesh HullOfMasks(const std::vector<View>& views, const std::vector<Image8>& masks,
                 const Eigen::Vector3d& low, const Eigen::Vector3d& high, double spacing);

}  // namespace keypose::synth
