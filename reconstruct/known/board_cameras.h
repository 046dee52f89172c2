// Cameras from a printed calibration board in the photographs: metric, upright, and in one frame
// for all poses on the same board.
#pragma once

#include <vector>

#include "core/values/calibration_board.h"
#include "core/values/camera.h"
#include "reconstruct/bundle/bundle_adjustment.h"

namespace keypose::reconstruct {

/// The board corners in one photograph.
struct BoardSighting {
  std::string name;
  std::vector<BoardCorner> corners;
  int lens = 0;  ///< of several
};

/// A lens before its photographs are placed.
struct BoardLens {
  Camera camera;
  bool focal_known = false;
};

struct BoardPosesOptions {
  int min_corners = 8;    ///< fewer corners do not determine a pose
  double max_rms_px = 3;  ///< a view with a larger error is left out
  BundleOptions bundle;   ///< selects the intrinsics that are solved for
};

struct BoardPoses {
  Scene scene;    ///< the placed views, in the board's frame [m], z up; no points
  Bodies bodies;  ///< the board's corners in the views, as body 0
  double rms_px = 0;
  /// views with fewer than min_corners, and views without a good pose above the board
  std::vector<std::string> too_few, rejected;
};

/// First estimates each view by itself from its corners (of the plane's two solutions, the better
/// one above the board is refined), then all with their shared camera by bundle adjustment.
///
/// @param camera       initial camera; if the focal length is not known, it is searched between 0.6
/// and 6 times the longer side
/// @param sightings    sorted by name
/// @throws InputError  a corner that the board does not have
/// Same bits for any thread count.
/// Source: Collins & Bartoli, "Infinitesimal plane-based pose estimation", IJCV 2014 (IPPE, as in
/// OpenCV).
BoardPoses PlaceByBoard(const Camera& camera, bool focal_known, const BoardLayout& board,
                        const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options);

/// The same for photographs of several lenses, which are placed apart: the board joins them.
/// @param lenses  BoardSighting::lens is an index into them
BoardPoses PlaceByBoard(const std::vector<BoardLens>& lenses, const BoardLayout& board,
                        const std::vector<BoardSighting>& sightings,
                        const BoardPosesOptions& options);

/// The board's corners in the views of a scene, as observations of `body`.
std::vector<BodyObservation> BoardObservations(const Scene& scene, const BoardLayout& board,
                                               const std::vector<BoardSighting>& sightings,
                                               int body, int min_corners);

/// The similarity from a scene of free scale to the board's frame, from the centres of the views in
/// both.
/// @throws InputError  fewer than 3 views in common, or their centres coincide
Similarity3 BoardFromScene(const Scene& board, const Scene& scene);

}  // namespace keypose::reconstruct
