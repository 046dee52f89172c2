// Soft light on a character: an area lamp that is fixed while the turntable turns, and ambient
// light of the room.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/surfaces/ray_scene.h"
#include "core/values/mesh.h"

namespace keypose::synth {

/// Unit direction from the character to a lamp at an azimuth about z and an elevation above the
/// table.
Eigen::Vector3d LampDirection(double azimuth_rad, double elevation_rad);

/// The visible share of the lamp and of the room per vertex, computed once for all turns of the
/// table. Same bits for any thread count.
class LightField {
 public:
  /// @param normals  V x 3 unit
  /// @param elevation_rad  of the lamp
  LightField(const Mesh& surface, const PointsX3& normals, const RayScene& scene,
             double elevation_rad);
  /// Visible share of the lamp per vertex, V in [0,1].
  std::vector<float> Lamp(double azimuth_rad) const;
  /// Visible share of the room per vertex, V in [0,1].
  const std::vector<float>& sky() const { return sky_; }

 private:
  std::int64_t vertices_;
  std::vector<std::uint8_t> lamp_;  // kTurns rows of V: 0, 128, 255
  std::vector<float> sky_;
};

/// Light on the table (z = 0), on a square grid around the axis.
class TableLight {
 public:
  /// Contact shadow (ambient occlusion), the same for all turns.
  /// @param half_width  of the grid [m]
  TableLight(const RayScene& scene, double half_width);
  /// Visible share of the lamp on the grid, for one turn.
  std::vector<float> Lamp(double azimuth_rad, double elevation_rad) const;
  /// Bilinear value of a grid at a point of the table; 1 outside.
  double At(const std::vector<float>& grid, double x, double y) const;
  const std::vector<float>& sky() const { return sky_; }

 private:
  const RayScene* scene_;
  double half_width_;
  std::vector<float> sky_;
};

}  // namespace keypose::synth
