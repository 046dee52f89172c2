// Removes the windows' bias from depth maps: a window averages the depth of a curved surface, which
// fills creases and flattens bumps.
#pragma once

#include "views/prepared/prepared_view.h"
#include "views/stereo/plane_map.h"

namespace keypose::reconstruct {

struct WindowBiasOptions {
  /// of the window's weights, along an axis [px^2]; 0 changes nothing
  double variance = 16;
  double largest_cost = 1.0;  ///< pixels with a larger matching cost are neither used nor corrected
  /// pixels with a larger expected depth error are neither used nor corrected [px on the surface]
  double largest_error = 1.0;
};

/// A flat window on a curved surface finds the surface's mean depth under the window. Its error is
/// half the window's variance times the Laplacian of inverse depth, which is subtracted. The
/// Laplacian comes from a least-squares paraboloid over a radius of 10 pixels. It uses groups of
/// four places, rotated by 90 degrees about the pixel, so that slants cancel. Groups that cross a
/// depth edge are left out, and a pixel with few groups is not corrected.
///
/// @param map  of `camera`, packed or not, after the last pass
/// Cost: about 0.05 CPU seconds per megapixel that has planes.
/// Source: first term of the inverse of a blur (Van Cittert); Kanade & Okutomi, PAMI 1994, avoid
/// the same bias by adaptive windows.
void CorrectWindowBias(const Pinhole& camera, const WindowBiasOptions& options,
                       stereo::PlaneMap* map);

}  // namespace keypose::reconstruct
