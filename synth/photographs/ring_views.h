// Exact cameras of turntable rings, and the empty set behind the character.
#pragma once

#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "synth/photographs/photographer_options.h"

namespace keypose::synth {

/// A camera on a ring. In the world's frame, the table is fixed and the camera moves around it.
struct RingView {
  View view;
  double azimuth_rad = 0;  ///< of the camera about z; the lamp keeps its angle to it
  /// pose of the figure on the turntable; `view` is given in the figure's frame
  Rigid3 table_from_world;
  int ring = 0;
};

/// Cameras that see all of `points`, ring after ring, named IMG_0001.jpg, IMG_0002.jpg, ...
std::vector<RingView> PlaceCameras(const PointsX3& points, const PhotographerOptions& options);

/// Linear RGB of the empty set, static in the camera's frame.
ImageF Backdrop(const PhotographerOptions& options);

}  // namespace keypose::synth
