// A photograph prepared for stereo: undistorted, scaled to the working resolution, cropped to its
// mask, with a pyramid.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"

namespace keypose {

/// A camera without distortion; pixel centres lie at whole numbers (unlike core's Camera), which
/// suits array indices.
struct Pinhole {
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;

  Eigen::Vector2d Project(const Eigen::Vector3d& x_in_camera) const;
  /// The point with z = 1 that projects to (x, y).
  Eigen::Vector3d Ray(double x, double y) const { return {(x - cx) / fx, (y - cy) / fy, 1.0}; }
  Eigen::Matrix3d K() const;
};

/// Brightness and mask in one number, so that one read gives both: bits 1..15 are grey (0..32767),
/// bit 0 is set inside the mask. Grey is 128 plus the difference from the local mean, which removes
/// shading.
using GreyMask = ImageT<std::uint16_t>;
constexpr float kGreyScale =
    255.0f / 65535.0f;  ///< times a GreyMask pixel gives grey levels 0..255
inline bool InMask(std::uint16_t pixel) { return (pixel & 1) != 0; }

struct PreparedView {
  struct Level {
    Pinhole camera;
    GreyMask grey;
  };
  std::string name;
  int scene_index = -1;  ///< of Scene::views
  Rigid3 camera_from_world;
  /// 0 is the working resolution; each next level has half of the resolution
  std::vector<Level> levels;
  Image8 color;      ///< RGB at level 0
  double noise = 0;  ///< standard deviation of the sensor's noise at level 0, grey levels
  std::int64_t masked_pixels = 0;  ///< at level 0

  const Pinhole& camera(int level = 0) const { return levels[level].camera; }
  Eigen::Vector3d Center() const { return camera_from_world.Inverse().translation; }
};

/// @param image  RGB, of the size that view.camera has
/// @param mask   1 channel of the same size; > 127 is object
/// @param scale  working resolution over the photograph's, in (0, 1]
/// @param levels pyramid levels, >= 1
/// @return masked_pixels == 0 and no levels when the mask is empty, or the image too small for that
/// many levels
/// @throws InputError  sizes differ; names the image
PreparedView PrepareView(const View& view, int scene_index, const Image8& image, const Image8& mask,
                         double scale, int levels);

/// The names of the first eight views, and the number of the others, for a message.
std::string NameList(const std::vector<std::string>& names);

}  // namespace keypose
