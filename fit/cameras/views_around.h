// Cameras from all sides, each so near and so turned that it shows the mesh where a mask is.
#pragma once

#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

struct ViewAround {
  Rigid3 camera_from_world;
  double overlap = 0;   ///< of silhouette and mask: intersection over union
  double likeness = 0;  ///< correlation of colours where both are, -1 to 1
};

/// Those that look most like the photograph, in small: outlines and colours together. Nobody held
/// the camera askew, so the mesh's z points upwards in each.
///
/// @param mesh     the template; it may be bent otherwise than the figure
/// @param texture  RGB; empty: outlines alone
/// @param scene    of the mesh
/// @param most     how many, the best first
/// Same bits for any thread count.
std::vector<ViewAround> ViewsAround(const Mesh& mesh, const Image8& texture, const RayScene& scene,
                                    const PreparedView& photograph, int most);

}  // namespace keypose::fit
