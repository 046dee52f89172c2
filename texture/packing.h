// Places flat charts in the unit square without overlap, as large as they go.
#pragma once

#include <vector>

#include "core/mesh.h"

namespace keypose::texture {

/// A flat chart to place.
struct Shape {
  UvsX2 points;     ///< [any unit, the same for all shapes]
  FacesX3 corners;  ///< counter-clockwise triangles
};

struct PackingOptions {
  int texture_size = 2048;  ///< [px]
  int gutter_px = 4;        ///< least distance between two charts, and from the border
};

struct Packing {
  std::vector<UvsX2> uvs;  ///< per shape, in [0,1], turned and moved but never mirrored, all scaled alike
  double utilisation = 0;  ///< share of the square that triangles cover
};

/// @throws QualityError  not even a thousandth of the square can be used (far too many shapes for the gutter)
/// Bottom-left placement of bitmaps, eight directions a shape, tallest first; the scale is found by bisection. Deterministic.
Packing Pack(const std::vector<Shape>& shapes, const PackingOptions& options);

}  // namespace keypose::texture
