// The set of a filmed shot: a table before a wall, a lamp, a camera; and pictures
// of a clay character on it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/values/camera.h"
#include "core/values/image.h"
#include "core/values/mesh.h"
#include "synth/worlds/world.h"

namespace keypose::synth {

struct ShotSetOptions {
  int width = 960, height = 540;
  double focal_35mm = 50;  ///< 35 mm equivalent
  double k1 = -0.04, k2 = 0.01, p1 = 2e-4, p2 = -1e-4;
  double principal_shift_px = 3;
  double camera_azimuth_deg = -78, camera_elevation_deg = 14;
  double distance_m = 0.85;
  double lamp_azimuth_deg = -140, lamp_elevation_deg = 50;
  double ambient = 0.40, lamp = 0.72;  ///< light on white clay, linear
  double gloss = 0.03;
  double grain = 1;  ///< sensor noise, as a factor on an ordinary camera's
  double blur_px = 0.55;
  double vignetting = 0.08;
  std::uint64_t seed = 1;
  /// One sentence per fault; empty when valid.
  std::vector<std::string> Problems() const;
};

/// A picture and the share of each pixel that the character covers.
struct ShotPicture {
  Image8 picture;  ///< sRGB
  Image8 matte;    ///< 255 where the character covers the whole pixel
};

/// World: the table is z = 0, x to the right; the wall is at y = 0.33 m.
class ShotSet {
 public:
  /// @throws UsageError  bad options
  explicit ShotSet(const ShotSetOptions& options);
  const View& view() const { return view_; }
  /// The set without the character.
  /// @param grain  number of its sensor noise
  Image8 Plate(std::uint64_t grain) const;
  /// The character in a pose, with light and shadow of its own.
  ///
  /// @param points  the surface's vertices in the pose, in the character's frame
  /// @param grain   of the picture's sensor noise; the same number gives the same noise
  /// Same bits for any thread count.
  ShotPicture Film(const World& world, const PointsX3& points,
                   const Similarity3& world_from_character, std::uint64_t grain) const;

 private:
  Eigen::Vector3d Ray(int x, int y, double sx, double sy) const;  ///< in world
  Eigen::Vector3d SetColor(const Eigen::Vector3d& ray) const;
  Image8 Developed(ImageF linear, std::uint64_t grain) const;

  ShotSetOptions options_;
  View view_;
  Rigid3 world_from_camera_;
  Eigen::Matrix3d turn_;
  std::vector<Eigen::Vector2d> corners_;  ///< rays with z = 1 at the pixels' corners
  ImageF empty_;                          ///< linear light
};

}  // namespace keypose::synth
