// Takes out of depth maps what windows put in: the depth of a curved surface is averaged over the
// window, which fills creases and flattens bumps.
#pragma once

#include "reconstruct/stereo/plane_map.h"
#include "views/prepared/prepared_view.h"

namespace keypose::reconstruct {

struct WindowBiasOptions {
  /// of the places that a window listens to, along an axis [px^2]; 0 changes nothing
  double variance = 16;
  double largest_cost = 1.0;  ///< pixels that match worse neither tell curvature nor are corrected
  /// the same for those whose depth is expected to be off by more [px on the surface]
  double largest_error = 1.0;
};

/// A flat window that is laid on a curved surface settles at the surface's mean depth under it: off
/// by half the window's variance times the Laplacian of inverse depth. That is subtracted. The
/// Laplacian is a least-squares paraboloid over 10 pixels around, of places that lie in fours round
/// the pixel, so that slants cancel; fours that reach over an edge of depth are left out, and a
/// pixel with few is left as it is.
///
/// @param map  of `camera`, packed or not, after the last pass. Costs about 0.05 CPU seconds a
/// megapixel that has planes.
/// Source: first term of the inverse of a blur (Van Cittert); the same that Kanade & Okutomi, PAMI
/// 1994, avoid by windows that adapt.
void CorrectWindowBias(const Pinhole& camera, const WindowBiasOptions& options, PlaneMap* map);

}  // namespace keypose::reconstruct
