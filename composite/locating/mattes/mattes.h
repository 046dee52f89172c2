// Mattes made from pictures.
#pragma once

#include "core/values/image.h"

namespace keypose::composite {

/// Where a frame differs from the clean plate: 255, 1 channel. Exposure is adjusted, plain shadows
/// (darker, of the same colour) are left out, specks removed and holes filled. Empty (all 0) when
/// nothing differs.
/// @param frame, plate  RGB of one size
Image8 MatteFromPlate(const Image8& frame, const Image8& plate);

/// Where the figure is, from its drawn silhouette that is right to about `within_px`: colours of
/// what is surely figure and surely background decide in between.
/// @param picture  RGB
/// @param covered  1 channel of the same size, 255 where the mesh is drawn
/// @return of the same size; equal to `covered` when it covers nothing
/// Source: GrabCut, Rother, Kolmogorov & Blake, SIGGRAPH 2004, as in OpenCV.
Image8 MatteByColours(const Image8& picture, const Image8& covered, int within_px);

}  // namespace keypose::composite
