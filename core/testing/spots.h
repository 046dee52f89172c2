// A textured figure without symmetry: for tests of cameras that are found by its look.
#pragma once

#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose {

/// About 2 wide, around the origin, with its own texture coordinates by longitude and latitude.
Mesh SpottedLump();

/// Spots of many sizes.
Image8 Spots();

}  // namespace keypose
