// Cameras from a printed calibration board that photographs show: metric, upright, and in one frame
// for all poses that stand on it.
#pragma once

#include <vector>

#include "core/calibration_board.h"
#include "core/camera.h"
#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

/// What one photograph shows of the board.
struct BoardSighting {
  std::string name;
  std::vector<BoardCorner> corners;
};

struct BoardPosesOptions {
  int min_corners = 8;    ///< fewer tell no pose
  double max_rms_px = 3;  ///< a view that misses the board by more is left out
  BundleOptions bundle;   ///< which intrinsics are solved for
};

struct BoardPoses {
  Scene scene;    ///< the placed views, in the board's frame [m], z up; no points
  Bodies bodies;  ///< the board's corners in them, as body 0
  double rms_px = 0;
  /// views with fewer than min_corners, and views that fit no pose above the board
  std::vector<std::string> too_few, rejected;
};

/// Each view by itself from its corners (the plane's two solutions, the better one above the board
/// refined), then all with their shared camera by bundle adjustment.
///
/// @param camera       to start from; its focal length is sought between 0.6 and 6 times the longer
/// side when it is not known
/// @param sightings    sorted by name
/// @throws InputError  a corner that the board does not have
/// Same bits for any thread count.
/// Source: Collins & Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014 (IPPE, as in
/// OpenCV).
BoardPoses PlaceByBoard(const Camera& camera, bool focal_known, const BoardLayout& plate,
                        const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options);

/// The board's corners in the views of a scene, as observations of `body`.
std::vector<BodyObservation> BoardObservations(const Scene& scene, const BoardLayout& plate,
                                               const std::vector<BoardSighting>& sightings,
                                               int body, int min_corners);

/// The similarity that takes a scene with free scale into the board's frame, from the centres of
/// views that both hold.
/// @throws InputError  fewer than 3 views in common, or their centres coincide
Similarity3 BoardFromScene(const Scene& board, const Scene& scene);

}  // namespace keypose::reconstruct
