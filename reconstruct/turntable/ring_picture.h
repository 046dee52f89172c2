// A picture of the estimated cameras, for the report.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose::reconstruct {

struct CameraPictureOptions {
  int size_px = 640;      ///< width and height of each of the four parts
  double worst_px = 1.0;  ///< reprojection error that is drawn in the last colour of the scale
};

/// Cameras as frusta and sparse points as dots, in orthographic projection: left from above (first
/// camera at the bottom), right from the side (from the first camera). Upper row: cameras coloured
/// by ring, grey without a ring. Lower row: by their mean reprojection error, blue (0) to yellow
/// (worst_px and more), grey without observations.
///
/// @param scene         upright, z up, object near the origin
/// @param ring_of_view  one per view; -1 for none
/// @throws InputError   no views, or another number of ring_of_view
Image8 DrawCameras(const Scene& scene, const std::vector<int>& ring_of_view,
                   const CameraPictureOptions& options = {});

}  // namespace keypose::reconstruct
