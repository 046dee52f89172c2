// Cameras that no one filmed with: round the actor, or along a path.
#pragma once

#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/mesh.h"

namespace keypose::motion {

struct FreeViewOptions {
  int width = 960, height = 720;  ///< px
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  double turns = 1;           ///< of an orbit, over all frames; counter-clockwise seen from above
  double elevation_deg = 12;  ///< of an orbit's camera above the actor's middle
};

/// A camera for each frame, that goes round the actor at one distance and follows where it goes.
/// @param frames  points of each frame
std::vector<View> OrbitViews(const std::vector<Mesh>& frames, const FreeViewOptions& options);

/// A camera at a time.
struct CameraKey {
  double frame = 0;
  Eigen::Vector3d eye, look_at;
  double fov_deg = 40;  ///< vertical
};

/// A camera for each of `count` frames, smoothly through the keys; before the first and after the
/// last it stands. Keys in order of their frames, at least one.
/// @throws InputError  eye and target coincide
std::vector<View> PathViews(const std::vector<CameraKey>& keys, int count,
                            const FreeViewOptions& options);

/// {"keys": [{"frame": 0, "eye": [x, y, z], "look_at": [x, y, z], "fov_deg": 40}, ...]}
/// @param name  of the file, for messages
/// @throws InputError  not such JSON; names the key
std::vector<CameraKey> ParseCameraPath(const std::string& text, const std::string& name);

}  // namespace keypose::motion
