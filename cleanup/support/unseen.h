// How much of a closed mesh no camera has seen: it was closed by guess there.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::cleanup {

/// Shares of the mesh's area.
struct UnseenSurface {
  double share = 0;       ///< in no camera's sight, soles left out
  double sole_share = 0;  ///< in no camera's sight, because the figure stands on it
};

/// A camera sees a face if its middle is inside the picture, the mesh does not hide it, and the
/// line of sight is 10 degrees or more above the face: below that, nothing is measured in a
/// photograph. Soles are unseen faces within 5 % of the height from the lowest point that face down
/// by more than 45 degrees.
///
/// @param mesh   closed, oriented outwards, z up
/// @param views  in the mesh's frame; none: nothing is seen
/// @throws InputError  no faces
/// Cost: one ray for each face and camera, until one sees it. Same bits for any thread count.
UnseenSurface MeasureUnseen(const Mesh& mesh, const std::vector<View>& views);

}  // namespace keypose::cleanup
