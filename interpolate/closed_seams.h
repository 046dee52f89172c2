// Seams of keys whose vertices are doubled there, as PLY and glTF need it for
// texture coordinates.
#pragma once

#include <vector>

#include "core/values/mesh.h"
#include "interpolate/timing/rules.h"

namespace keypose::interpolation {

/// Joins the vertices that a seam doubles, so that the surface does not part
/// there between keys, and doubles them again in the frames. Vertices that some
/// key has at different places stay apart. Keys without seams keep their bits.
class ClosedSeams {
 public:
  /// @param keys  one or more, as they were given: turned and scaled, doubles
  /// may differ in bits
  /// @pre all have as many vertices as the first
  ClosedSeams(const std::vector<PointsX3>& keys, const FacesX3& faces);

  /// Number of vertices that are joined to others.
  int joined() const { return joined_; }
  /// As many as were given, in their order.
  const FacesX3& faces() const { return faces_; }
  std::vector<PointsX3> Closed(std::vector<PointsX3> keys) const;
  Rules Closed(Rules rules) const;
  /// Points of a frame for all vertices that were given.
  PointsX3 Opened(const PointsX3& frame) const;

 private:
  FacesX3 faces_;
  std::vector<int> kept_;      // vertices that stay
  std::vector<int> of_given_;  // for each given vertex its number among them
  int joined_ = 0;
};

}  // namespace keypose::interpolation
