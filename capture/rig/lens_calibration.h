// Lenses from a board in many places.
#pragma once

#include <string>
#include <vector>

#include "capture/rig/board_sighting.h"
#include "core/values/camera.h"

namespace keypose::capture {

struct RigCamera {
  std::string name;
  int width = 0, height = 0;
};

/// A lens, and how well it explains the boards.
struct CalibratedLens {
  Camera camera;
  double rms_px = 0, worst_px = 0;
  int boards = 0, corners = 0, left_out = 0;  ///< left out: boards that no lens explains
  double coverage = 0;  ///< share of an 8 x 6 grid of the picture in which corners were seen
};

/// Share of an 8 x 6 grid of the picture that holds corners.
double CornerCoverage(const std::vector<BoardSighting>& sightings, int camera,
                      const RigCamera& size);

/// A camera's lens: two focal lengths, principal point, two radial and two tangential coefficients.
/// Boards whose corners miss by more than a pixel and three times the median are left out.
///
/// @param camera  whose sightings are used
/// @param most    boards that are used, spread over all
/// @throws InputError  fewer than five boards; names the camera
/// Source: Zhang, TPAMI 2000, as in OpenCV.
CalibratedLens CalibrateLens(const std::vector<BoardSighting>& sightings, int camera,
                             const RigCamera& size, const BoardLayout& board, int most);

/// The board in the camera's frame.
Rigid3 BoardPose(const BoardSighting& sighting, const Camera& camera, const BoardLayout& board);

}  // namespace keypose::capture
