// Corners of boards that the cameras of a room see.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "capture/rig/board_sighting.h"
#include "capture/rig/lens_calibration.h"
#include "core/pictures/fit_view.h"
#include "core/values/calibration_board.h"
#include "core/values/camera.h"

namespace keypose::capture {

// Small errors that are the same on every machine, with a standard deviation of about `size`.
inline double Wobble(int i, double size) {
  const double x = std::sin(12.9898 * i) * 43758.5453;
  return 3.46 * size * (x - std::floor(x) - 0.5);
}

struct Room {
  std::vector<View> views;
  std::vector<RigCamera> cameras;
  std::vector<BoardSighting> sightings;
  BoardLayout board;
};

// Cameras on an arc about a place where a board is turned and moved; it lies on the floor first.
inline Room MakeRoom(int cameras, int frames, double noise_px,
                     const BoardLayout& board = {9, 7, 0.06, 0.045}) {
  Room room;
  room.board = board;
  for (int c = 0; c < cameras; ++c) {
    View view;
    view.name = "cam" + std::to_string(c + 1);
    view.camera = {1000,      800,   950.0 + 5 * c, 955.0 + 4 * c, 503.0 + c,
                   398.0 - c, -0.06, 0.02,          5e-4,          -3e-4};
    const double a = 0.6 * c - 0.9;
    view.camera_from_world = LookAt({2.4 * std::sin(a), -2.4 * std::cos(a), 1.3}, {0, 0, 0.5});
    room.views.push_back(view);
    room.cameras.push_back({view.name, 1000, 800});
  }
  int count = 0;
  for (int f = 0; f < frames; ++f) {
    Rigid3 motion;
    if (f > 0) {
      motion.rotation = Eigen::AngleAxisd(0.5 * std::sin(1.7 * f), Eigen::Vector3d::UnitZ()) *
                        Eigen::AngleAxisd(0.9 + 0.5 * std::sin(0.9 * f), Eigen::Vector3d::UnitX()) *
                        Eigen::AngleAxisd(0.5 * std::cos(1.3 * f), Eigen::Vector3d::UnitY());
      motion.translation = {0.6 * std::sin(0.7 * f), 0.4 * std::cos(1.1 * f),
                            0.7 + 0.4 * std::sin(0.5 * f)};
    }
    for (int c = 0; c < cameras; ++c) {
      BoardSighting sighting{c, f, {}};
      for (int id = 0; id < room.board.CornerCount(); ++id) {
        const Eigen::Vector2d p = room.views[c].Project(motion * room.board.Corner(id));
        if (p.x() < 2 || p.y() < 2 || p.x() > 998 || p.y() > 798) continue;
        sighting.corners.push_back(
            {id, p + Eigen::Vector2d(Wobble(++count, noise_px), Wobble(++count, noise_px))});
      }
      room.sightings.push_back(sighting);
    }
  }
  return room;
}

}  // namespace keypose::capture
