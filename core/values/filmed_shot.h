// What is known of a filmed shot: its camera, and where the character is in each of its frames.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"

namespace keypose {

/// One frame as it was filmed.
struct ShotFrame {
  int frame = 0;        ///< number on the film's own clock: filmed at frame / fps seconds
  std::string picture;  ///< its file name in the film's folder
  std::string pose;     ///< the key pose that it shows; empty: one that was not scanned
  Rigid3 camera_from_world;
  /// Where the character is: from the coordinates of its mesh in this pose.
  Similarity3 world_from_character;
  std::string method;  ///< how it was found: "features", "outlines", "clicks" or "given"
  std::optional<double> contour_px;  ///< mean distance of the outlines [px]
  std::optional<double> iou;         ///< of the silhouettes
  std::optional<int> inliers;        ///< of matched features
};

/// Where a moving camera was between filmed frames.
struct CameraBetween {
  double frame = 0;  ///< on the film's own clock, as ShotFrame::frame, with fractions
  Rigid3 camera_from_world;
};

struct FilmedShot {
  Camera camera;                  ///< one lens for the whole shot
  std::string focal = "given";    ///< its focal length's source: "exif", "solved", "given", "kept"
  double focal_uncertainty = 0;   ///< standard deviation over the focal length; 0: not known
  bool still = true;              ///< the camera does not move: all camera_from_world are equal
  double fps = 12;                ///< of the film's clock
  std::vector<ShotFrame> frames;  ///< at least one, ascending by `frame`
  /// Of a moving camera, ascending, within the frames and at none of their times; may be empty.
  std::vector<CameraBetween> between;
};

/// The character's mesh as seen from a frame's camera: x_in_camera = scale * rotation * x + t.
inline Similarity3 CameraFromCharacter(const ShotFrame& frame) {
  const Eigen::Matrix3d turn = frame.camera_from_world.rotation.toRotationMatrix();
  return {frame.world_from_character.scale, turn * frame.world_from_character.rotation,
          frame.camera_from_world * frame.world_from_character.translation};
}

}  // namespace keypose
