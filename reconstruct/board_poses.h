// Cameras from a printed plate that photographs show: metric, upright, and in one frame for all poses that stand on it.
#pragma once

#include <vector>

#include "core/camera.h"
#include "core/plate.h"
#include "reconstruct/bundle_adjustment.h"

namespace keypose::reconstruct {

/// What one photograph shows of the plate.
struct BoardSighting {
  std::string name;
  std::vector<PlateCorner> corners;
};

struct BoardPosesOptions {
  int min_corners = 8;    ///< fewer tell no pose
  double max_rms_px = 3;  ///< a view that misses the plate by more is left out
  BundleOptions bundle;   ///< which intrinsics are solved for
};

struct BoardPoses {
  Scene scene;    ///< the placed views, in the plate's frame [m], z up; no points
  Bodies bodies;  ///< the plate's corners in them, as body 0
  double rms_px = 0;
  std::vector<std::string> too_few, rejected;  ///< views with fewer than min_corners, and views that fit no pose above the plate
};

/// Each view by itself from its corners (the plane's two solutions, the better one above the plate refined), then all with their shared
/// camera by bundle adjustment.
///
/// @param camera       to start from; its focal length is sought between 0.6 and 6 times the longer side when it is not known
/// @param sightings    sorted by name
/// @throws InputError  a corner that the plate does not have
/// Same bits for any thread count.
/// Source: Collins & Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014 (IPPE, as in OpenCV).
BoardPoses PlaceByBoard(const Camera& camera, bool focal_known, const PlateLayout& plate, const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options);

/// The plate's corners in the views of a scene, as observations of `body`.
std::vector<BodyObservation> BoardObservations(const Scene& scene, const PlateLayout& plate, const std::vector<BoardSighting>& sightings,
                                               int body, int min_corners);

/// The similarity that takes a scene with free scale into the plate's frame, from the centres of views that both hold.
/// @throws InputError  fewer than 3 views in common, or their centres coincide
Similarity3 BoardFromScene(const Scene& board, const Scene& scene);

}  // namespace keypose::reconstruct
