// Reduces a cloud to the density that a mesh can represent.
#pragma once

#include "core/values/mesh.h"

namespace keypose::reconstruct {

/// Replaces all points that share a cell of a cubic grid, and whose normals are in the same octant,
/// by one point.
///
/// Position, colour and normal are means weighted by the square of the confidence (by 1 without
/// confidences). The confidence is the mean weighted by itself, so that confident points dominate.
/// The two sides of a thin sheet have opposite normals and stay separate.
/// @param cloud  P points with unit normals, finite
/// @param cell   edge of the grid's cells, > 0
/// @return at most P points, in the order of the cells; a point that is alone in its cell keeps its
/// values to rounding
/// Same bits for any thread count.
/// Cost: a sort of P keys of 64 bits.
PointCloud MergeWithinCells(const PointCloud& cloud, double cell);

}  // namespace keypose::reconstruct
