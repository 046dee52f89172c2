// Polygons as triangles: fans, and something better where a fan would fold over.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "core/values/mesh.h"

namespace keypose {

/// The triangles of one polygon: numbers of its corners, counted within it.
using LocalTriangles = std::vector<std::array<int, 3>>;

/// Cuts a polygon whose fan from the first corner has a triangle that faces away from the polygon
/// or has no area, as a concave one may. Ears are cut off one after the other, in the plane across
/// the polygon's mean normal; of a polygon that crosses itself, what is left becomes a fan.
/// @param corners  n vertices of the points
/// @return  n - 2 triangles with the polygon's winding; empty: nothing is better than its fan
/// Cost: linear if the fan is right, else as a rule the corners squared, at worst cubed.
LocalTriangles CutOfPolygon(const PointsX3& points, const int* corners, std::size_t count);

/// Which polygons of a mesh are not fans, found once for vertices and texture coordinates alike.
class PolygonCuts {
 public:
  /// @param corners  vertices of all polygons, one after the other
  /// @param sizes    corners of each polygon; those with fewer than three have no triangle
  PolygonCuts(const PointsX3& points, const std::vector<int>& corners,
              const std::vector<std::size_t>& sizes);

  /// Gives the triangles of those polygons other corners.
  /// @param corners  of all polygons, as above: vertices, or texture coordinates
  /// @param faces    the fans of these corners, in the polygons' order
  void Apply(const std::vector<int>& corners, FacesX3* faces) const;

 private:
  struct Cut {
    std::size_t first_corner = 0;
    Eigen::Index first_face = 0;
    LocalTriangles triangles;
  };
  std::vector<Cut> cuts_;
};

}  // namespace keypose
