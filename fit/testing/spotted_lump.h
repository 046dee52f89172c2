// A textured figure without symmetry, and photographs of it from a rig: for tests of cameras.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/image.h"
#include "core/mesh.h"
#include "views/prepared/prepared_view.h"

namespace keypose::fit {

/// About 2 wide, around the origin, with its own texture coordinates by longitude and latitude.
Mesh SpottedLump();

/// Spots of many sizes.
Image8 Spots();

/// Cameras that look at the mesh, 20 degrees from above.
std::vector<View> RingAround(const Mesh& mesh, const std::vector<double>& azimuths_deg);

/// A photograph of 420 x 420 pixels without shading, with what it shows as mask.
PreparedView PhotographOf(const Mesh& mesh, const Image8& texture, const View& view);

}  // namespace keypose::fit
