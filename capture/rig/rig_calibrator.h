// Intrinsics and places of fixed cameras, from a calibration board that is moved before them.
#pragma once

#include <string>
#include <vector>

#include "capture/rig/board_sighting.h"
#include "capture/rig/lens_calibration.h"
#include "core/values/calibration_board.h"
#include "core/values/camera.h"
#include "core/values/progress.h"

namespace keypose::capture {

struct RigCalibratorOptions {
  int floor_frame = 0;    ///< the frame in which the board lies on the floor: it becomes z = 0
  int least_corners = 8;  ///< a sighting with fewer is not used
  int most_boards = 60;   ///< sightings a camera's lens is first estimated from
  /// ways to turn the board in its plane that nobody can tell apart (BoardPattern::Turns)
  int turns = 1;
  /// of each camera, where they are known: they stay; empty: estimated from the boards
  std::vector<Camera> lenses;
};

/// How well one camera is known.
struct RigCameraReport {
  double rms_px = 0;  ///< of its corners
  double worst_px = 0;
  int boards = 0, corners = 0;
  double coverage = 0;  ///< share of an 8 x 6 grid of its picture in which corners were seen
  int shared = 0;       ///< boards that another camera saw at the same moment
};

struct RigResult {
  std::vector<View> views;  ///< metres; the world is the board on the floor: z up
  std::vector<RigCameraReport> cameras;
  double rms_px = 0;
};

/// Each lens by itself, cameras joined by boards that two of them saw at once, then everything
/// together: lenses, places, and the board in each frame (Ceres, Huber at 1 px).
///
/// @throws InputError  a camera that saw the board too rarely, or never together with the others;
/// no board in the floor's frame; says which and what to do
/// Source: Zhang, "A flexible new technique for camera calibration", TPAMI 2000, for the lenses (as
/// in OpenCV); Triggs et al., "Bundle adjustment - a modern synthesis", 1999.
RigResult CalibrateRig(const std::vector<BoardSighting>& sightings,
                       const std::vector<RigCamera>& cameras, const BoardLayout& board,
                       const RigCalibratorOptions& options, Progress* progress = nullptr);

}  // namespace keypose::capture
