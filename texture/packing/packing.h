// Places flat charts in the unit square without overlap, at the largest possible scale.
#pragma once

#include <vector>

#include "core/values/mesh.h"

namespace keypose::texture {

/// A flat chart to place.
struct Shape {
  UvsX2 points;     ///< [any unit, the same for all shapes]
  FacesX3 corners;  ///< counter-clockwise triangles that form a disk
};

struct PackingOptions {
  int texture_size = 2048;  ///< [px]
  int gutter_px = 4;        ///< least distance between two charts; half of it to the border
  int effort = 600;         ///< moves of the search, in units of 16; cost grows with it
};

struct Packing {
  /// per shape, in [0,1], rotated and moved but never mirrored, all with the same scale
  std::vector<UvsX2> uvs;
  double scale = 0;        ///< sides of the square per unit of the shapes
  double utilisation = 0;  ///< share of the square that triangles cover
};

/// Searches places and rotations on a grid, then separates the shapes exactly. Deterministic.
/// @throws QualityError  the shapes do not fit with this gutter (far too many of them)
Packing Pack(const std::vector<Shape>& shapes, const PackingOptions& options);

}  // namespace keypose::texture
