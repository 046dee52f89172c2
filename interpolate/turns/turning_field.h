// A field of vectors on vertices that turns with the body between two keys.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "interpolate/maps/face_maps.h"

namespace keypose::interpolation {

/// exp(t body_turn) exp(t vertex_turn) ((1-t) a + t b'), where b' is b turned back to the first
/// key: a at 0, b at 1.
class TurningField {
 public:
  /// @param maps  with vertex_turns
  /// @param a, b  V x 3, at the first and the second key
  TurningField(const SegmentMaps& maps, const PointsX3& a, const PointsX3& b);
  PointsX3 At(double t) const;

  struct Vertex {
    double axis[3], angle, start[3], rise[3];
  };
  const std::vector<Vertex>& vertices() const { return vertices_; }

 private:
  Eigen::Vector3d body_turn_;
  std::vector<Vertex> vertices_;
};

}  // namespace keypose::interpolation
