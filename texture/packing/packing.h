// Places flat charts in the unit square without overlap, as large as they go.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::texture {

/// A flat chart to place.
struct Shape {
  UvsX2 points;     ///< [any unit, the same for all shapes]
  FacesX3 corners;  ///< counter-clockwise triangles that form a disk
};

struct PackingOptions {
  int texture_size = 2048;  ///< [px]
  int gutter_px = 4;        ///< least distance between two charts; half of it to the border
  int effort = 600;         ///< moves of the search, in sixteens; cost grows with it
};

struct Packing {
  /// per shape, in [0,1], turned and moved but never mirrored, all scaled alike
  std::vector<UvsX2> uvs;
  double scale = 0;        ///< sides of the square per unit of the shapes
  double utilisation = 0;  ///< share of the square that triangles cover
};

/// @throws QualityError  the shapes do not fit with this gutter (far too many of them)
/// A search for places and turns on a grid, then the shapes are moved apart exactly. Deterministic.
Packing Pack(const std::vector<Shape>& shapes, const PackingOptions& options);

}  // namespace keypose::texture
