// Photographs of the spotted lump from a rig: for tests of cameras.
#pragma once

#include <vector>

#include "core/testing/spots.h"
#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// Cameras that look at the mesh, 20 degrees from above.
std::vector<View> RingAround(const Mesh& mesh, const std::vector<double>& azimuths_deg);

/// A photograph of 420 x 420 pixels without shading, with what it shows as mask.
PreparedView PhotographOf(const Mesh& mesh, const Image8& texture, const View& view);

}  // namespace keypose::fit
