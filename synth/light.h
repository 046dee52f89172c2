// Soft light on a character: an area lamp that stands still while the turntable turns, and the sky
// of the room.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/mesh.h"
#include "core/ray_scene.h"

namespace keypose::synth {

/// Unit direction from the character to the lamp when the lamp stands at an azimuth about z and an
/// elevation above the table.
Eigen::Vector3d LampDirection(double azimuth_rad, double elevation_rad);

/// How much of the lamp and of the room each vertex sees, computed once for all turns of the table.
/// Same bits for any thread count.
class LightField {
 public:
  /// @param normals  V x 3 unit
  /// @param elevation_rad  of the lamp
  LightField(const Mesh& surface, const PointsX3& normals, const RayScene& scene,
             double elevation_rad);
  /// Share of the lamp that each vertex sees, V in [0,1].
  std::vector<float> Lamp(double azimuth_rad) const;
  /// Share of the room that each vertex sees, V in [0,1].
  const std::vector<float>& sky() const { return sky_; }

 private:
  std::int64_t vertices_;
  std::vector<std::uint8_t> lamp_;  // kTurns rows of V: 0, 128, 255
  std::vector<float> sky_;
};

/// Light that reaches the table (z = 0), on a square grid about the axis.
class TableLight {
 public:
  /// Contact darkness, the same for all turns.
  /// @param half_width  of the grid [m]
  TableLight(const RayScene& scene, double half_width);
  /// Share of the lamp over the grid for one turn.
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
