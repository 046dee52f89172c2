// Brings a cloud to the density that a mesh can use.
#pragma once

#include "core/mesh.h"

namespace keypose::reconstruct {

/// One point for all points that share a cell of a cubic grid and whose normals lie in the same
/// octant.
///
/// Position, colour and normal are means weighted by the square of the confidence (all alike
/// without confidences); the confidence is the mean weighted by itself, so that sure points speak.
/// Two sides of a thin sheet, whose normals are opposite, stay apart.
/// @param cloud  P points with unit normals, finite
/// @param cell   edge of the grid's cells, > 0
/// @return at most as many points, in the order of the cells; points in cells of their own keep
/// their values to rounding Same bits for any thread count.
/// Cost: a sort of P keys of 64 bits.
PointCloud MergeWithinCells(const PointCloud& cloud, double cell);

}  // namespace keypose::reconstruct
