// The shot as a scene for Blender: a script that builds it, and the files that it reads.
//
// Blender's camera has no lens distortion: its pictures are those of the pinhole camera with the
// same focal length and centre, so plates for it are undistorted.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"

namespace keypose::composite {

/// How Blender describes a pinhole camera. Sensor fit is horizontal.
struct BlenderCamera {
  double lens_mm = 50, sensor_width_mm = 36;
  double shift_x = 0, shift_y = 0;  ///< shares of the picture's width
  double pixel_aspect_y = 1;        ///< height of a pixel over its width
  Eigen::Matrix4d matrix_world;     ///< looks along its own -z, y up
};
BlenderCamera BlenderCameraOf(const View& view);

/// The light of a shot, as `composite` has learnt it or was told.
struct BlenderLight {
  /// Of the character over its texture, by the normal n in world: rows 1, x, y, z, xy, yz, xz,
  /// xx - yy, 3 zz - 1; columns red, green, blue.
  Eigen::Matrix<double, 9, 3> on_character;
  /// Of the table's light; the rest is not shadowed. Both 0: no shadow.
  double sky = 0, lamp = 0;
  Eigen::Vector3d towards_lamp = Eigen::Vector3d::UnitZ();  ///< unit
  double lamp_radius_rad = 0.1;                             ///< of its disk
  Eigen::Vector3d middle, right, up;  ///< of the table, below the character; axes are unit
  double diagonal = 1;                ///< of the character
};

struct BlenderShot {
  View view;
  std::vector<View> path;  ///< of a moving camera: its place in each picture; else empty
  double fps = 24;
  int first_picture = 0;                   ///< Blender's frame of the animation's frame 0
  int pictures = 0;                        ///< of the whole shot
  std::vector<std::string> textures;       ///< files beside the script; the first shows
  std::string plate, film;                 ///< clean plate; first picture of the numbered film
  std::optional<BlenderLight> light = {};  ///< none: the texture glows as it is
};

/// Names and contents of shot.py, shot.json, character.bin and character.pc2.
struct BlenderFile {
  std::string name, bytes;
};
/// @param frames  the animation's, with positions in world: as many as it has
/// @param uvs, uv_faces  v up
std::vector<BlenderFile> BlenderFiles(const BlenderShot& shot, const FacesX3& faces,
                                      const UvsX2& uvs, const FacesX3& uv_faces,
                                      const std::vector<PointsX3>& frames);

}  // namespace keypose::composite
